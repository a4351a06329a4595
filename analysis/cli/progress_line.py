"""Show the progress of a command in a terminal, or report it to another program."""

from __future__ import annotations

import logging
import sys
from argparse import ArgumentParser
from collections.abc import Callable, Iterator
from contextlib import contextmanager

LOG = logging.getLogger(__name__)


def add_steps(parser: ArgumentParser) -> None:
    """Add ``--steps`` to a command's parser."""
    parser.add_argument(
        "--steps",
        action="store_true",
        help="print one line per step to standard error, for other programs",
    )


@contextmanager
def telling(*, lines: bool = False) -> Iterator[Callable[[str], None]]:
    """Show the current step in a status line if stderr is a terminal, or log it with --verbose.

    Parameters
    ----------
    lines : bool
        Whether to print one line per step, such as ``step: testing``, for other programs.
    """
    if lines:
        yield _print_step
        return
    if LOG.isEnabledFor(logging.INFO):
        yield LOG.info
        return
    from rich.console import Console

    console = Console(stderr=True)
    with console.status("") as status:
        yield lambda words: status.update(f"{words} ...")


def _print_step(words: str) -> None:
    print(f"step: {words}", file=sys.stderr, flush=True)
