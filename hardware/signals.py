"""Convert signals that end a session into exceptions, so that the plate is always silenced.

By default, SIGTERM and SIGHUP end Python without leaving ``with`` blocks or running ``finally``
clauses. After an exception, `Session.run` or the driver's ``close`` (`slipscale.hardware.driver`)
silences the plate.

An exception raised by a signal handler can be lost in a destructor, in a library's callback, or in
an ``except BaseException: pass``, as in PsychoPy when it opens a window. The handler therefore also
records the signal. `raise_if_ended`, which is called in every frame, wait and prompt and at the end
of the block, raises the exception again.

If an exception were raised between two exits of an exit stack, the remaining exits would be
skipped. To prevent this, code should call the function that `signals_raise` yields before it leaves
the ``with`` block; a signal then raises its exception at the end of the block.
"""

from __future__ import annotations

import math
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING

from slipscale.faults import RigError

if TYPE_CHECKING:
    from slipscale.hardware.driver import PlateDriver

# Pressing Ctrl-C twice, or closing the terminal, which sends several signals, must not interrupt
# the code that silences the plate. Further signals are ignored only for this time, so that another
# signal can stop a session in which the first exception was lost.
IGNORED_S = 2.0
# Includes signals that would stop or abort the program and leave a generator on: SIGQUIT (Ctrl-\\)
# and SIGTSTP (Ctrl-Z). SIGBREAK is specific to Windows.
ENDINGS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGTSTP", "SIGBREAK")


class EndedBySignal(KeyboardInterrupt):
    """Raised if the operating system or a user terminates the program with a signal."""


class _Noted:
    """Signal that ended the current block, if any."""

    name = ""


def note_signal(number: int) -> EndedBySignal:
    """Record a signal that ends the program, and return the exception to raise."""
    _Noted.name = signal.Signals(number).name
    return EndedBySignal(_Noted.name)


def raise_if_ended() -> None:
    """Raise `EndedBySignal` if a signal was recorded, because the exception may have been lost."""
    if _Noted.name:
        raise EndedBySignal(_Noted.name)


@contextmanager
def signals_raise() -> Iterator[Callable[[], None]]:
    """Convert signals that end the program into `EndedBySignal` inside the block.

    For `IGNORED_S` after the first signal, other signals are ignored while the plate is silenced.
    If other code suppresses the exception, it is raised again at the end of the block. Only
    the main thread may call this function.

    Yields
    ------
    callable
        Function to call before leaving the ``with`` block. After this call, the first signal raises
        its exception at the end of the block, and a second signal raises it immediately.
    """
    first_s, leaving = -math.inf, False

    def leave() -> None:
        nonlocal leaving
        leaving = math.isinf(first_s)

    if sys.exception() is None:  # unless the program is already ending
        raise_if_ended()
    outside, _Noted.name = _Noted.name, ""

    def handle(number: int, _: FrameType | None) -> None:
        nonlocal first_s, leaving
        now_s = time.monotonic()
        if now_s - first_s < IGNORED_S:
            return
        first_s = now_s
        ended = note_signal(number)
        if not leaving:
            raise ended
        leaving = False  # The next signal can then stop code that hangs at the end of the block.

    numbers = [getattr(signal, name) for name in ENDINGS if hasattr(signal, name)]
    before = {number: signal.signal(number, handle) for number in numbers}
    try:
        yield leave
        raise_if_ended()
    except Exception as error:
        # If a library suppressed the signal's exception and then failed, the signal is the cause.
        if isinstance(error, RigError) or _follows(error):
            raise
        raise_if_ended()
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _Noted.name = outside


def _follows(error: BaseException | None) -> bool:
    """Return whether an error is an `EndedBySignal`, or was raised while handling one."""
    while error is not None and not isinstance(error, EndedBySignal):
        error = error.__context__
    return error is not None


@contextmanager
def silent_on_signals(driver: PlateDriver) -> Iterator[None]:
    """Close the driver and silence the plate at the end of the block, even after a signal."""
    with signals_raise() as leave:
        try:
            yield
        finally:
            try:
                leave()
            finally:
                driver.close()
