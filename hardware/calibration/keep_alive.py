"""Questions at the terminal while a plate vibrates; the plate is kept alive while a person types.

A board silences itself if it receives nothing for its watchdog time, so `typed` repeatedly calls a
function while it waits. `typed` waits in short steps: otherwise a signal that arrives just as a
piped question appears would be noticed only after the next line.
"""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Callable
from threading import Thread

ALIVE_S = 0.1


def typed(question: str, alive: Callable[[], object]) -> str:
    """Return the line that a person types; call ``alive`` every 0.1 s until then.

    Raises
    ------
    EOFError
        If standard input has ended.
    Exception
        Exceptions from ``alive``, immediately.
    """
    print(question, end="", flush=True)
    try:
        descriptor = sys.stdin.fileno()
    except (io.UnsupportedOperation, ValueError):  # not a file, so it does not block
        return _whole(sys.stdin.readline().encode())
    read = bytearray()
    reader = Thread(target=_read_line, args=(descriptor, read), name="typed line", daemon=True)
    reader.start()
    while reader.is_alive():
        reader.join(ALIVE_S)
        alive()
    return _whole(bytes(read))


def _read_line(descriptor: int, read: bytearray) -> None:
    """Read up to a line feed and no further, because the next question's answer may follow."""
    while not read.endswith(b"\n"):
        byte = os.read(descriptor, 1)
        if not byte:
            return
        read += byte


def _whole(line: bytes) -> str:
    if not line:
        raise EOFError
    return line.decode("utf-8", "replace").rstrip("\r\n")
