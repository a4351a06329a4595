"""Detect a broken connection to the X server, and end the session cleanly.

When the connection breaks, Xlib calls ``exit(1)`` during any call and in any thread, without
running ``finally`` blocks. This module installs a handler that only records that the
connection is broken. The next frame then raises `WindowLost`, which ends the session like any other
rig fault. A program must not call Xlib after the connection has broken. The window is therefore not
closed, and the process ends before other libraries try to close it.
"""

from __future__ import annotations

import atexit
import ctypes
import os
import select
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

from slipscale.faults import RIG_FAULT, RigError

LIBRARY = "libX11.so.6"
GONE = 0
if sys.platform == "linux":
    GONE = select.POLLHUP | select.POLLERR | select.POLLRDHUP

_HANDLER = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p)
_EXIT_HANDLER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)


class WindowLost(RigError):
    """The participant's window was lost, because the connection to the display server broke."""

    def __init__(self) -> None:
        super().__init__(
            "the participant's window is closed: the display server ended or closed the "
            "connection. Start the server again, then resume the run"
        )


class Connection:
    """Detects the loss of the X server; does nothing on platforms without X11."""

    def __init__(self) -> None:
        self.lost = False
        self._xlib: Any = None
        self._poll: Any = None

    def guard(self) -> None:
        """Install the handler that Xlib calls when the connection breaks."""
        if sys.platform == "linux":
            self._xlib = ctypes.CDLL(LIBRARY)
            self._poll = select.poll()
            _KEPT.extend((_HANDLER(self._broken), _EXIT_HANDLER(_stay)))
            self._xlib.XSetIOErrorHandler(_KEPT[-2])

    def watch(self, window: Any) -> None:
        """Watch the X connection of an open pyglet window."""
        if self._xlib is None:
            return
        display = ctypes.cast(window.context.x_display, ctypes.c_void_p)
        if hasattr(self._xlib, "XSetIOErrorExitHandler"):  # Xlib 1.7 or later
            self._xlib.XSetIOErrorExitHandler(display, _KEPT[-1], None)
        self._poll.register(self._xlib.XConnectionNumber(display), GONE)

    def check(self) -> None:
        """Raise `WindowLost` if the connection is broken."""
        if self._poll is not None and self._poll.poll(0):
            self._lose()
        if self.lost:
            raise WindowLost

    @contextmanager
    def used(self) -> Iterator[None]:
        """Raise `WindowLost` instead of exceptions caused by a broken connection."""
        self.check()
        try:
            yield
        except Exception:
            self.check()
            raise

    def _lose(self) -> None:
        if not self.lost:
            self.lost = True
            atexit.register(_end)  # runs before the handlers that libraries registered earlier

    def _broken(self, _display: int) -> int:
        """Record a broken connection. Xlib calls this handler in the thread of the failed call."""
        self._lose()
        if threading.current_thread() is not threading.main_thread():
            threading.Event().wait()  # blocks this thread until the process ends
        return 0


# Keep the handlers alive, because Xlib may call them until the process ends.
_KEPT: list[Any] = []


def _stay(_display: int, _data: int) -> None:
    """Keep Xlib from exiting the process, so that the next frame can end the session."""


def _end() -> NoReturn:
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(RIG_FAULT)
