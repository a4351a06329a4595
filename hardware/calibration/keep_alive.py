"""Ask questions at the terminal while keeping the connection to a vibrating plate alive.

A board silences the plate if it receives nothing for its watchdog time. To prevent this, `typed`
calls a function repeatedly while it waits for an answer. It waits in short steps, so that signals
are handled without delay.
"""

from __future__ import annotations

import io
import os
import select
import sys
from collections.abc import Callable
from threading import Thread

ALIVE_S = 0.1


def typed(question: str, alive: Callable[[], object]) -> str:
    """Ask a question and return the answer; call ``alive`` every 0.1 s while waiting.

    Raises
    ------
    EOFError
        If standard input has ended.
    Exception
        Any exception that ``alive`` raises, without waiting for the answer.
    """
    # A terminal shows the answer and its line feed; the output of other programs needs one.
    print(question, end="" if sys.stdin.isatty() else "\n", flush=True)
    try:
        descriptor = sys.stdin.fileno()
    except (io.UnsupportedOperation, ValueError):  # Input that is not a file does not block.
        return _whole(sys.stdin.readline().encode())
    read = bytearray()
    if sys.platform == "win32":  # There, only sockets can be waited for.
        reader = Thread(target=_read_line, args=(descriptor, read), name="typed line", daemon=True)
        reader.start()
        while reader.is_alive():
            reader.join(ALIVE_S)
            alive()
        return _whole(bytes(read))
    # A thread that still reads while Python ends can crash the process.
    while not read.endswith(b"\n"):
        ready, _, _ = select.select([descriptor], [], [], ALIVE_S)
        byte = os.read(descriptor, 1) if ready else None
        if byte == b"":
            break
        read += byte or b""
        alive()
    return _whole(bytes(read))


def _read_line(descriptor: int, read: bytearray) -> None:
    """Read exactly one line, because later lines may answer later questions."""
    while not read.endswith(b"\n"):
        byte = os.read(descriptor, 1)
        if not byte:
            return
        read += byte


def _whole(line: bytes) -> str:
    if not line:
        raise EOFError
    return line.decode("utf-8", "replace").rstrip("\r\n")
