"""Signals that end a session become exceptions, so that every `finally` silences the plate.

Without this SIGTERM and SIGHUP end Python with no ``with`` block left and no ``finally`` run. What
silences then: the driver's ``close`` (`slipscale.hardware.driver`), in a session `Session.run`
before it.
"""

from __future__ import annotations

import math
import signal
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType

    from slipscale.hardware.driver import PlateDriver

# Whoever presses Ctrl-C twice, or closes the terminal (which sends several signals), must not
# interrupt what silences the plate. No longer: an exception can be lost in a library's callback,
# and a session must never become unstoppable.
IGNORED_S = 2.0
ENDINGS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")  # the last two are Unix' and Windows' own


class EndedBySignal(KeyboardInterrupt):
    """The operating system, or somebody, asked the program to end."""


@contextmanager
def signals_raise() -> Iterator[None]:
    """Turn signals that end the program into `EndedBySignal` inside the block.

    For `IGNORED_S` after the first, others are ignored: the plate is being silenced.
    Only the main thread may call this.
    """
    first_s = -math.inf

    def handle(number: int, _: FrameType | None) -> None:
        nonlocal first_s
        now_s = time.monotonic()
        if now_s - first_s < IGNORED_S:
            return
        first_s = now_s
        raise EndedBySignal(signal.Signals(number).name)

    numbers = [getattr(signal, name) for name in ENDINGS if hasattr(signal, name)]
    before = {number: signal.signal(number, handle) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def silent_on_signals(driver: PlateDriver) -> Iterator[None]:
    """Close the plate's driver, which silences it, however the block ends: signals included."""
    with signals_raise():
        try:
            yield
        finally:
            driver.close()
