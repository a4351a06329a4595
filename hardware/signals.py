"""Convert signals that end a session to exceptions, so that every `finally` silences the plate.

By default, SIGTERM and SIGHUP end Python without leaving ``with`` blocks or running ``finally``
clauses. With exceptions, the driver's ``close`` (`slipscale.hardware.driver`) silences the plate;
in a session, `Session.run` does so before it.

An exception raised by a handler can be lost: in a destructor, in a library's callback, or in an
``except BaseException: pass`` (PsychoPy has one where its window opens). The signal is therefore
also recorded. `raise_if_ended` raises it again at every frame, wait and prompt, and so does the
end of the block.

A signal that arrives while a block is being left (for example, between two exits of a stack) would
skip the remaining exits. Code that leaves a block therefore announces it first, and the signal is
raised at the block's end.
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

# Pressing Ctrl-C twice, or closing the terminal (which sends several signals), must not interrupt
# the code that silences the plate. Signals are not ignored for longer, because an exception can be
# lost in a library's callback and a session must never become unstoppable.
IGNORED_S = 2.0
# Includes signals that would stop or abort the program and leave a generator on: SIGQUIT (Ctrl-\\)
# and SIGTSTP (Ctrl-Z). SIGBREAK is specific to Windows.
ENDINGS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGTSTP", "SIGBREAK")


class EndedBySignal(KeyboardInterrupt):
    """The operating system or a user asked the program to end."""


class _Noted:
    """The signal that asked the current block to end; empty before."""

    name = ""


def note_signal(number: int) -> EndedBySignal:
    """Record a signal that asked the program to end; return the exception to raise."""
    _Noted.name = signal.Signals(number).name
    return EndedBySignal(_Noted.name)


def raise_if_ended() -> None:
    """Raise `EndedBySignal` if a signal asked the program to end and the exception was lost."""
    if _Noted.name:
        raise EndedBySignal(_Noted.name)


@contextmanager
def signals_raise() -> Iterator[Callable[[], None]]:
    """Convert signals that end the program to `EndedBySignal` inside the block.

    For `IGNORED_S` after the first signal, others are ignored while the plate is being silenced. A
    block that lost the exception still ends with it. Only the main thread may call this.

    Yields
    ------
    callable
        Call it before leaving the block: the first signal after it is raised at the block's end, a
        second one immediately.
    """
    first_s, leaving = -math.inf, False

    def leave() -> None:
        nonlocal leaving
        leaving = math.isinf(first_s)

    if sys.exception() is None:  # unless the block is itself part of ending
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
        leaving = False  # code that hangs on exit can be ended

    numbers = [getattr(signal, name) for name in ENDINGS if hasattr(signal, name)]
    before = {number: signal.signal(number, handle) for number in numbers}
    try:
        yield leave
        raise_if_ended()
    except Exception as error:
        # A library's error after it swallowed the exception is not the cause.
        if isinstance(error, RigError) or _follows(error):
            raise
        raise_if_ended()
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _Noted.name = outside


def _follows(error: BaseException | None) -> bool:
    """Return whether an error was raised while `EndedBySignal` was being handled."""
    while error is not None and not isinstance(error, EndedBySignal):
        error = error.__context__
    return error is not None


@contextmanager
def silent_on_signals(driver: PlateDriver) -> Iterator[None]:
    """Close the plate's driver, which silences it, however the block ends, including signals."""
    with signals_raise() as leave:
        try:
            yield
        finally:
            try:
                leave()
            finally:
                driver.close()
