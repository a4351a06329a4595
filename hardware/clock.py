"""Provide the only clocks in Slipscale: the computer's clock, and a virtual clock for pilots."""

from __future__ import annotations

import sys
import time
from typing import Protocol


class Clock(Protocol):
    """Common interface for clocks, with all times in seconds."""

    def now(self) -> float:
        """Return the time in seconds."""

    def sleep(self, duration_s: float) -> None:
        """Wait until ``duration_s`` seconds have passed on this clock."""

    def suspended_s(self) -> float:
        """Return for how long the computer was suspended, which `now` does not count."""


class SystemClock:
    """Computer's monotonic clock, offset to start at ``start_s``.

    The clock uses ``time.perf_counter``, so that the time stamps of key events can be converted to
    its time.
    """

    def __init__(self, start_s: float = 0.0) -> None:
        self._start = time.perf_counter() - start_s

    def now(self) -> float:
        """Return the time in seconds."""
        return time.perf_counter() - self._start

    def sleep(self, duration_s: float) -> None:
        """Wait for ``duration_s`` seconds."""
        if duration_s > 0:
            time.sleep(duration_s)

    def suspended_s(self) -> float:
        """Return for how long the computer was suspended since it was started."""
        # Elsewhere, `time.perf_counter` also counts the time in which the computer was suspended.
        if sys.platform != "linux":
            return 0.0
        return time.clock_gettime(time.CLOCK_BOOTTIME) - time.monotonic()


class VirtualClock:
    """Clock that advances without waiting, so that a pilot does not take an hour.

    >>> clock = VirtualClock()
    >>> clock.sleep(2.5)
    >>> clock.now()
    2.5
    """

    def __init__(self, start_s: float = 0.0) -> None:
        self._now = start_s
        self._suspended_s = 0.0

    def now(self) -> float:
        """Return the virtual time in seconds."""
        return self._now

    def sleep(self, duration_s: float) -> None:
        """Advance the time by ``duration_s`` seconds."""
        self._now += max(duration_s, 0.0)

    def suspended_s(self) -> float:
        """Return the total duration of all calls of `suspend`."""
        return self._suspended_s

    def suspend(self, duration_s: float) -> None:
        """Let time pass for everything but this clock, as if the computer had been suspended."""
        self._suspended_s += duration_s

    def set(self, time_s: float) -> None:
        """Set the time; a resumed pilot continues at the last time in the journal."""
        self._now = time_s
