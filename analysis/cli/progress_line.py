"""What a command is doing, as one line on the terminal."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


@contextmanager
def telling() -> Iterator[Callable[[str], None]]:
    """Show what goes on as one line on stderr, where that is a terminal."""
    from rich.console import Console  # noqa: PLC0415

    console = Console(stderr=True)
    with console.status("") as status:
        yield lambda words: status.update(f"{words} ...")
