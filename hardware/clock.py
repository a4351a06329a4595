"""The only clocks in Slipscale: the machine's, and a virtual one so that pilots do not wait."""

from __future__ import annotations

import time
from typing import Protocol


class Clock(Protocol):
    """Seconds since the clock was created, and a method that waits."""

    def now(self) -> float:
        """Return the time in seconds since the clock was created."""

    def sleep(self, duration_s: float) -> None:
        """Wait for ``duration_s`` seconds of this clock."""


class SystemClock:
    """The machine's monotonic clock, starting at ``start_s``.

    It counts ``time.perf_counter``, so the time stamps of key events can be converted to it.
    """

    def __init__(self, start_s: float = 0.0) -> None:
        self._start = time.perf_counter() - start_s

    def now(self) -> float:
        """Return the time in seconds since the clock's start."""
        return time.perf_counter() - self._start

    def sleep(self, duration_s: float) -> None:
        """Wait for ``duration_s`` seconds."""
        if duration_s > 0:
            time.sleep(duration_s)


class VirtualClock:
    """A clock that advances only on request: a pilot's hour takes a second.

    >>> clock = VirtualClock()
    >>> clock.sleep(2.5)
    >>> clock.now()
    2.5
    """

    def __init__(self, start_s: float = 0.0) -> None:
        self._now = start_s

    def now(self) -> float:
        """Return the virtual time in seconds."""
        return self._now

    def sleep(self, duration_s: float) -> None:
        """Advance the time by ``duration_s`` seconds."""
        self._now += max(duration_s, 0.0)

    def set(self, time_s: float) -> None:
        """Set the time to ``time_s``; a resumed pilot continues at its journal's time."""
        self._now = time_s
