"""Questions at the terminal while a plate vibrates: something keeps it alive while a person types.

A board silences itself when it hears nothing for its watchdog's time, so `typed` calls a function
again and again while it waits. It also waits in short steps: a signal that arrives in the instant a
piped question appears would otherwise be noticed only after the next line was typed.
"""

from __future__ import annotations

import io
import os
import sys
from threading import Thread
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

ALIVE_S = 0.1


def typed(question: str, alive: Callable[[], object]) -> str:
    """Return the line that a person types; call ``alive`` every 0.1 s until then.

    Raises
    ------
    EOFError
        Standard input has ended.
    Exception
        What ``alive`` raises, at once.
    """
    print(question, end="", flush=True)
    try:
        descriptor = sys.stdin.fileno()
    except (io.UnsupportedOperation, ValueError):  # not a file: it does not block
        return _whole(sys.stdin.readline().encode())
    read = bytearray()
    reader = Thread(target=_read_line, args=(descriptor, read), name="typed line", daemon=True)
    reader.start()
    while reader.is_alive():
        reader.join(ALIVE_S)
        alive()
    return _whole(bytes(read))


def _read_line(descriptor: int, read: bytearray) -> None:
    """Read up to a line feed, and not a byte more: the next question's answer may wait there."""
    while not read.endswith(b"\n"):
        byte = os.read(descriptor, 1)
        if not byte:
            return
        read += byte


def _whole(line: bytes) -> str:
    if not line:
        raise EOFError
    return line.decode("utf-8", "replace").rstrip("\r\n")
