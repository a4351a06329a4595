"""Provide what drivers of serial devices require from the computer: time, ports, regular calls.

Everything that depends on real time is here, so tests can run drivers in virtual time.
"""

from __future__ import annotations

from collections.abc import Callable
from threading import Event, Thread
from typing import Protocol

from slipscale.hardware.backends.serial_board.link import Line
from slipscale.hardware.backends.serial_board.serial_line import BAUD, SerialLine
from slipscale.hardware.clock import Clock, SystemClock


class Host(Clock, Protocol):
    """Interface for the computer to which a device is connected."""

    def open_line(self, port: str, *, baud: int = BAUD) -> Line:
        """Open a serial port. Raises `PlateFault`."""

    def repeat(self, step: Callable[[], bool], interval_s: float) -> Callable[[], None]:
        """Call a function regularly until it returns False; return a function that ends this."""


class SystemHost(SystemClock):
    """Computer on which the program runs."""

    def open_line(self, port: str, *, baud: int = BAUD) -> Line:
        """Open a serial port. Raises `PlateFault`."""
        return SerialLine(port, baud=baud)

    def repeat(self, step: Callable[[], bool], interval_s: float) -> Callable[[], None]:
        """Call a function regularly in a thread until it returns False.

        Returns
        -------
        callable
            Function that ends the calls, and waits for a call in progress.
        """
        ended = Event()

        def run() -> None:
            while not ended.wait(interval_s) and step():
                pass

        thread = Thread(target=run, name="serial device", daemon=True)
        thread.start()

        def end() -> None:
            ended.set()
            thread.join()

        return end
