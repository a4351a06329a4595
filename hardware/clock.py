"""The only clocks there are: the machine's, and a virtual one so that pilots do not wait."""

from __future__ import annotations

import time
from typing import Protocol


class Clock(Protocol):
    """Seconds since the clock was made, and a way to let them pass."""

    def now(self) -> float:
        """Return the time in seconds since the clock's start."""

    def sleep(self, duration_s: float) -> None:
        """Let ``duration_s`` seconds pass."""


class SystemClock:
    """The machine's monotonic clock, from ``start_s`` at construction.

    It counts ``time.perf_counter``, so a key event's time stamp can be put on it.
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
    """A clock that moves only when told to: a pilot's hour passes in a second.

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
        """Move the time on by ``duration_s`` seconds."""
        self._now += max(duration_s, 0.0)

    def set(self, time_s: float) -> None:
        """Move the time to ``time_s``: a resumed pilot goes on at its journal's time."""
        self._now = time_s
