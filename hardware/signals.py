"""Signals that end a session become exceptions, so that every `finally` silences the plate.

Without this SIGTERM and SIGHUP end Python with no ``with`` block left and no ``finally`` run. What
silences then: the driver's ``close`` (`slipscale.hardware.driver`), in a session `Session.run`
before it.

An exception that a handler raises can be lost: in a destructor, in a library's callback, in an
``except BaseException: pass`` (PsychoPy has one where its window opens). So the signal is noted
too. `raise_if_ended` raises it again at every frame, wait and prompt, and so does the end of the
block.

A signal that arrives while a block is being left (between two exits of a stack, say) would skip the
exits that remain. So whoever leaves says so first, and the signal is raised at the block's end.
"""

from __future__ import annotations

import math
import signal
import sys
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

from slipscale.faults import RigError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import FrameType

    from slipscale.hardware.driver import PlateDriver

# Whoever presses Ctrl-C twice, or closes the terminal (which sends several signals), must not
# interrupt what silences the plate. No longer: an exception can be lost in a library's callback,
# and a session must never become unstoppable.
IGNORED_S = 2.0
# Also those that would stop or abort the program with a generator left on: SIGQUIT (Ctrl-\\) and
# SIGTSTP (Ctrl-Z). SIGBREAK is Windows' own.
ENDINGS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGTSTP", "SIGBREAK")


class EndedBySignal(KeyboardInterrupt):
    """The operating system, or somebody, asked the program to end."""


class _Noted:
    """The signal that asked the block in progress to end; empty before it."""

    name = ""


def note_signal(number: int) -> EndedBySignal:
    """Note a signal that asked to end; return the exception for its handler to raise."""
    _Noted.name = signal.Signals(number).name
    return EndedBySignal(_Noted.name)


def raise_if_ended() -> None:
    """Raise `EndedBySignal` if a signal asked to end and the exception was lost."""
    if _Noted.name:
        raise EndedBySignal(_Noted.name)


@contextmanager
def signals_raise() -> Iterator[Callable[[], None]]:
    """Turn signals that end the program into `EndedBySignal` inside the block.

    For `IGNORED_S` after the first, others are ignored: the plate is being silenced. A block whose
    exception was lost ends with it all the same. Only the main thread may call this.

    Yields
    ------
    callable
        Call it before the block is left: the first signal after it is raised at the block's end,
        a second at once.
    """
    first_s, leaving = -math.inf, False

    def leave() -> None:
        nonlocal leaving
        leaving = math.isinf(first_s)

    if sys.exception() is None:  # unless the block is part of ending
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
        leaving = False  # what hangs while it is left can be ended

    numbers = [getattr(signal, name) for name in ENDINGS if hasattr(signal, name)]
    before = {number: signal.signal(number, handle) for number in numbers}
    try:
        yield leave
        raise_if_ended()
    except Exception as error:
        # What a library stumbled over after it had swallowed the exception is not the cause.
        if isinstance(error, RigError) or _follows(error):
            raise
        raise_if_ended()
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _Noted.name = outside


def _follows(error: BaseException | None) -> bool:
    """Return whether an error came up while `EndedBySignal` was being handled."""
    while error is not None and not isinstance(error, EndedBySignal):
        error = error.__context__
    return error is not None


@contextmanager
def silent_on_signals(driver: PlateDriver) -> Iterator[None]:
    """Close the plate's driver, which silences it, however the block ends: signals included."""
    with signals_raise() as leave:
        try:
            yield
        finally:
            try:
                leave()
            finally:
                driver.close()
