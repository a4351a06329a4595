"""Signals end a session through its `finally`, and an impatient second one does not cut that."""

import contextlib
import signal
import subprocess
import sys

import pytest

from slipscale.faults import RigError, UserError
from slipscale.hardware import signals
from slipscale.hardware.signals import (
    EndedBySignal,
    raise_if_ended,
    signals_raise,
    silent_on_signals,
)


@pytest.fixture
def clock(monkeypatch):
    """Return a list with the time, in s, by which signals are heard."""
    now_s = [100.0]
    monkeypatch.setattr(signals.time, "monotonic", lambda: now_s[0])
    return now_s


@pytest.mark.parametrize("name", [n for n in signals.ENDINGS if hasattr(signal, n)])
def test_each_signal_that_ends_a_program_is_raised(name):
    before = signal.getsignal(getattr(signal, name))
    with pytest.raises(EndedBySignal, match=name), signals_raise():
        signal.raise_signal(getattr(signal, name))
    assert signal.getsignal(getattr(signal, name)) is before


def test_a_second_signal_does_not_interrupt_what_silences_the_plate(clock):
    done = []

    def session():
        with signals_raise():
            try:
                signal.raise_signal(signal.SIGINT)
            finally:
                clock[0] += 0.9 * signals.IGNORED_S
                signal.raise_signal(signal.SIGINT)
                signal.raise_signal(signal.SIGTERM)
                done.append("silenced")

    with pytest.raises(EndedBySignal, match="SIGINT"):
        session()
    assert done == ["silenced"]


def test_a_session_that_goes_on_all_the_same_can_be_ended_again(clock):
    def session():
        with signals_raise():
            for _ in range(2):
                with pytest.raises(EndedBySignal):
                    signal.raise_signal(signal.SIGTERM)
                clock[0] += 1.1 * signals.IGNORED_S

    with pytest.raises(EndedBySignal):
        session()


def test_the_first_signal_while_a_block_is_left_cuts_no_exit_and_a_second_ends_what_hangs(clock):
    done = []

    def session(signals_while_left):
        with signals_raise() as leave:
            leave()
            for number in range(signals_while_left):
                signal.raise_signal(signal.SIGTERM)
                clock[0] += 1.1 * signals.IGNORED_S
                done.append(number)

    for count in (1, 2):
        with pytest.raises(EndedBySignal, match="SIGTERM"):
            session(count)
    assert done == [0, 0]


def test_a_signal_just_before_the_plate_is_silenced_does_not_keep_it_on():
    done = []

    class Driver:
        def close(self):
            signal.raise_signal(signal.SIGTERM)
            done.append("silent")

    with pytest.raises(EndedBySignal), silent_on_signals(Driver()):
        pass
    assert done == ["silent"]


class Dying:
    """A library's object in whose destructor the signal arrives: Python drops the exception."""

    def __del__(self):
        with contextlib.suppress(BaseException):  # Python itself would print it
            signal.raise_signal(signal.SIGTERM)


def test_a_signal_whose_exception_was_lost_is_raised_at_the_next_check():
    reached = []

    def session():
        with signals_raise():
            Dying()
            reached.append("destructor")
            raise_if_ended()
            reached.append("frame")

    with pytest.raises(EndedBySignal, match="SIGTERM"):
        session()
    assert reached == ["destructor"]
    raise_if_ended()  # the block is over, and so is its signal


def test_a_block_ends_by_its_signal_even_if_nothing_checks():
    with pytest.raises(EndedBySignal), signals_raise():
        Dying()


@pytest.mark.parametrize(
    "error, raised", [(AttributeError("half open"), EndedBySignal), (RigError("stuck"), RigError)]
)
def test_what_fails_after_a_lost_signal_is_the_signal_except_a_plate_that_fails(error, raised):
    def session():
        with signals_raise():
            Dying()
            raise error

    with pytest.raises(raised):
        session()


def test_an_error_while_the_session_ends_keeps_its_own_sentence():
    def session():
        with signals_raise():
            try:
                signal.raise_signal(signal.SIGTERM)
            finally:
                raise UserError("the disk is full")

    with pytest.raises(UserError, match="the disk is full"):
        session()


MAIN = """
import atexit, signal, sys
from slipscale import commands
# A parent that ignores a signal, such as nohup, hands this on.
signal.signal(signal.{name}, signal.default_int_handler if "{name}" == "SIGINT" else signal.SIG_DFL)
def end():
    signal.raise_signal(signal.{name})
{moment}
sys.exit(commands.main())
"""
MOMENTS = {
    "before the command": "commands.dispatch = lambda words: end()",
    "before it, and lost": """
import contextlib
from slipscale.hardware.signals import signals_raise
def dispatch(words):
    with contextlib.suppress(BaseException):
        end()
    with signals_raise():
        print("THE SESSION HAS BEGUN")
commands.dispatch = dispatch""",
    "while the process exits": "commands.dispatch = lambda words: 0; atexit.register(end)",
}


@pytest.mark.parametrize("name", [n for n in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, n)])
@pytest.mark.parametrize("moment", MOMENTS)
def test_a_signal_outside_the_session_ends_the_process_quietly(name, moment):
    code = MAIN.format(name=name, moment=MOMENTS[moment])
    words = [sys.executable, "-c", code]
    ended = subprocess.run(words, check=False, capture_output=True, text=True)
    assert (ended.returncode, ended.stdout, ended.stderr) == (130, "", "")
