"""What a command is doing, as one line on the terminal, or as lines for a program."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


@contextmanager
def telling(*, lines: bool = False) -> Iterator[Callable[[str], None]]:
    """Show what goes on: one line on stderr where that is a terminal.

    Parameters
    ----------
    lines : bool
        Instead, a line for each step, for a program that shows them: ``step: testing``.
    """
    if lines:
        yield _print_step
        return
    from rich.console import Console  # noqa: PLC0415

    console = Console(stderr=True)
    with console.status("") as status:
        yield lambda words: status.update(f"{words} ...")


def _print_step(words: str) -> None:
    print(f"step: {words}", file=sys.stderr, flush=True)
