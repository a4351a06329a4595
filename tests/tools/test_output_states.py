"""Random histories over every backend: a sample of the campaign, and that it can find a fault."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipscale.hardware.backends.daq_output import DaqOutput
from slipscale.hardware.backends.function_generator import FunctionGenerator
from slipscale.hardware.backends.generator_output import GeneratorOutput
from slipscale.hardware.backends.serial_board import supervision
from slipscale.hardware.backends.sound_card.driver import SoundCard
from slipscale.hardware.driver import PlateDriver
from tools.campaigns.output_states.histories import lived
from tools.campaigns.output_states.rigs import RIGS


@pytest.mark.parametrize("backend", RIGS)
@given(seed=st.integers(20_000, 10**9), events=st.integers(1, 20))
@settings(max_examples=12, deadline=None)
def test_no_history_leaves_a_wrong_amplitude_or_a_drive_that_is_on_unreported(
    backend, seed, events
):
    assert lived(backend, seed, events).broken == []


def broken(backend, count=60):
    return [each for seed in range(count) for each in lived(backend, seed).broken]


def test_a_generator_whose_settings_are_not_verified_breaks_promises(monkeypatch):
    monkeypatch.setattr(GeneratorOutput, "verify", lambda _: None)
    assert any("true amplitude" in each for each in broken("scpi keysight"))


def test_a_backend_that_does_not_silence_breaks_promises(monkeypatch):
    monkeypatch.setattr(FunctionGenerator, "_silence", lambda _: None)
    assert any("confirmed off, but" in each for each in broken("scpi rigol"))


def test_a_terminal_that_is_not_set_to_0_breaks_promises(monkeypatch):
    monkeypatch.setattr(DaqOutput, "_zero", lambda _: None)
    assert any("confirmed off, but" in each for each in broken("daq"))


def test_a_card_that_vanishes_unnoticed_breaks_promises(monkeypatch):
    monkeypatch.setattr(SoundCard, "_attend", lambda _: None)
    monkeypatch.setattr(SoundCard, "_until_ramped", lambda _: None)
    assert broken("sound")


def test_a_driver_that_does_not_compare_breaks_promises(monkeypatch):
    monkeypatch.setattr(PlateDriver, "confirm", lambda *_: None)
    monkeypatch.setattr(supervision, "check_status", lambda *_, **__: None)
    assert any("true amplitude" in each for each in broken("serial"))
