"""Signals end a session through its `finally`, and an impatient second one does not cut that."""

import signal

import pytest

from slipscale.hardware import signals
from slipscale.hardware.signals import EndedBySignal, signals_raise


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
    with signals_raise():
        for _ in range(2):
            with pytest.raises(EndedBySignal):
                signal.raise_signal(signal.SIGTERM)
            clock[0] += 1.1 * signals.IGNORED_S
