"""Plates in volts and in m/s² on a generator and on a sound card, without a calibration."""

import math
import sys
from dataclasses import replace
from unittest import mock

import pytest

from slipscale.faults import UserError
from slipscale.hardware.address import Plate
from slipscale.hardware.backends.drive_of_level import stated
from slipscale.hardware.backends.function_generator import FunctionGenerator
from slipscale.hardware.backends.sound_card.driver import SoundCard
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.emulator.generators import MAKES
from slipscale.hardware.errors import OverLimit
from slipscale.hardware.limits import PlateLimits
from slipscale.stimuli.quantity import made_by_plate
from slipscale.stimuli.surface import VirtualSurface
from tests.support.local_line import LocalLine
from tools.campaigns.output_states.rigs import Audio, AudioClock

PP, RMS = (made_by_plate("voltage", "V", each) for each in ("peak to peak", "RMS"))
ACCELERATION = made_by_plate("acceleration", "m/s²", "RMS")
LIMITS = PlateLimits(
    quantity=PP, level=240.0, deviation_level=0.5, frequency_min_hz=20.0, frequency_max_hz=1000.0
)


def plate(**changes):
    return Plate(limits=replace(LIMITS, **changes))


def generator(options, at):
    wire = LocalLine(MAKES["keysight"]())
    made = FunctionGenerator(
        wire,
        clock=VirtualClock(),
        plate=at,
        amplifier_gain=20.0,
        drive=stated("scpi", options, at),
    )
    made._machine = VirtualClock()
    return made, wire.generator.channel[1]


@pytest.mark.parametrize(
    "options, changes, level, vpp",
    [
        ({"frequency": 125.0}, {}, 120.0, 6.0),
        ({"frequency": 125.0}, {"quantity": RMS, "level": 80.0}, 60.0, 120 * math.sqrt(2) / 20),
        (
            {"frequency": 125.0, "per_volt": 4.0},
            {"quantity": ACCELERATION, "level": 40.0},
            20.0,
            0.5,
        ),
    ],
)
def test_a_generator_makes_the_level_at_the_stated_frequency(options, changes, level, vpp):
    made, channel = generator(options, plate(**changes))
    with made:
        told = made.present(VirtualSurface(level=level))
        assert (channel.frequency_hz, channel.open_vpp) == (125.0, pytest.approx(vpp, abs=1e-4))
        assert told.readback.kind == "applied"
        assert told.readback.level == pytest.approx(level, rel=1e-3)
        with pytest.raises(OverLimit):
            made.present(VirtualSurface(level=1.01 * made.limits.level))
    assert not channel.on


def test_a_sound_card_makes_volts_peak_to_peak():
    audio, at = Audio(), plate()
    card = SoundCard(
        "3",
        clock=VirtualClock(),
        plate=at,
        full_scale_v=150.0,
        drive=stated("sound", {"frequency": 125.0}, at),
    )
    card._machine = AudioClock(audio)
    with mock.patch.dict(sys.modules, {"sounddevice": audio}), card:
        told = card.present(VirtualSurface(level=120.0))
        assert card._carrier.frequency_hz == 125.0
        assert card._carrier.level == pytest.approx(60 / 150)
        assert told.readback.level == pytest.approx(120.0)


@pytest.mark.parametrize(
    "options, changes, said",
    [
        ({"frequency": 125.0, "per_volt": 2.0}, {}, "requires frequency=HZ$"),
        ({"per_volt": 2.0}, {"quantity": ACCELERATION}, "frequency=HZ,per_volt=LEVEL"),
        ({"frequency": 125.0}, {"quantity": ACCELERATION}, "frequency=HZ,per_volt=LEVEL"),
        ({"frequency": 5.0}, {}, "plate 'scpi': drive frequency 5"),
        ({"frequency": 125.0}, {"quantity": PlateLimits().quantity}, "in a quantity other than µm"),
    ],
)
def test_a_drive_that_does_not_fit_the_plate_is_refused(options, changes, said):
    with pytest.raises(UserError, match=said):
        stated("scpi", options, plate(**changes))


def test_nothing_stated_leaves_it_to_the_calibration():
    assert stated("scpi", {"gain": 20.0}, plate()) is None
