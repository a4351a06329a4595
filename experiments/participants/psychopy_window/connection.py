"""The connection to an X server, which can end before the session does.

Xlib's rule for a broken connection is ``exit(1)`` from within any call, in any thread: no
``finally`` runs. Ours: Xlib's handler only notes the loss, and the next frame raises `WindowLost`,
which ends the session like any other fault of the rig. From then on nothing of X may be called, so
the window is not closed, and the process ends before libraries close it at exit.
"""

from __future__ import annotations

import atexit
import ctypes
import os
import select
import sys
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NoReturn

from slipscale.faults import RIG_FAULT, RigError

if TYPE_CHECKING:
    from collections.abc import Iterator

LIBRARY = "libX11.so.6"
GONE = (
    select.POLLHUP | select.POLLERR | getattr(select, "POLLRDHUP", 0)
    if sys.platform == "linux"
    else 0
)

_HANDLER = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p)
_EXIT_HANDLER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)


class WindowLost(RigError):
    """The participant's window is gone with its display."""

    def __init__(self) -> None:
        super().__init__(
            "the participant's window is gone: the display server ended or closed the connection. "
            "Start it again, then resume the run"
        )


class Connection:
    """Notices that the X server is gone; elsewhere than under X11 there is nothing to notice."""

    def __init__(self) -> None:
        self.lost = False
        self._xlib: Any = None
        self._poll: Any = None

    def guard(self) -> None:
        """Have Xlib call us instead of ending the process."""
        if sys.platform == "linux":
            self._xlib = ctypes.CDLL(LIBRARY)
            self._poll = select.poll()
            _KEPT.extend((_HANDLER(self._broken), _EXIT_HANDLER(_stay)))
            self._xlib.XSetIOErrorHandler(_KEPT[-2])

    def watch(self, window: Any) -> None:
        """Watch the display of an open window of pyglet: PsychoPy gives it one of its own."""
        if self._xlib is None:
            return
        display = ctypes.cast(window.context.x_display, ctypes.c_void_p)
        if hasattr(self._xlib, "XSetIOErrorExitHandler"):  # from version 1.7 of Xlib on
            self._xlib.XSetIOErrorExitHandler(display, _KEPT[-1], None)
        self._poll.register(self._xlib.XConnectionNumber(display), GONE)

    def check(self) -> None:
        """Raise `WindowLost` once the connection is gone."""
        if self._poll is not None and self._poll.poll(0):
            self._lose()
        if self.lost:
            raise WindowLost

    @contextmanager
    def used(self) -> Iterator[None]:
        """Use the connection in the block: what fails there because it broke is `WindowLost`."""
        self.check()
        try:
            yield
        except Exception:
            self.check()
            raise

    def _lose(self) -> None:
        if not self.lost:
            self.lost = True
            atexit.register(_end)  # called before those of libraries, which were registered earlier

    def _broken(self, _display: int) -> int:
        """Note that a call met a broken connection: called by Xlib in the thread that called it."""
        self._lose()
        if threading.current_thread() is not threading.main_thread():
            threading.Event().wait()  # a library's own thread has nothing to go on with
        return 0


# What Xlib may call as long as the process lives.
_KEPT: list[Any] = []


def _stay(_display: int, _data: int) -> None:
    """Return to the call, which fails: the next frame ends the session."""


def _end() -> NoReturn:
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(RIG_FAULT)
