"""A plate on a sound card: against a PortAudio that records the samples it was given."""

import math
import sys
from dataclasses import replace
from datetime import UTC, datetime
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.faults import UserError
from slipscale.hardware.address import split_address
from slipscale.hardware.backends.drive_of_level import DriveOfLevel
from slipscale.hardware.backends.sound_card.carrier import RAMP_S, Carrier
from slipscale.hardware.backends.sound_card.driver import OPTIONS, SoundCard
from slipscale.hardware.calibration.record import Device, DriveChain, Provenance, write_calibration
from slipscale.hardware.calibration.stored import read_calibration
from slipscale.hardware.calibration.sweep import SweepPlan, calibration_from, sweep
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.errors import (
    ConnectionLost,
    OverLimit,
    PlateBusy,
    PlateNotFound,
    PlateTimeout,
    StillVibrating,
    WrongDevice,
)
from slipscale.hardware.records import Output
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.surface import VirtualSurface
from slipscale.stimuli.texture import Grating

RATE_HZ = 192_000
FULL_SCALE_V = 20.0
RESONANCE_HZ = 30_500.0
UM_PP_PER_V = 2.3 / 15
SURFACE = VirtualSurface(level=1.2)
BLOCK = 512


class PortAudioError(Exception):
    pass


class Card:
    """Stands for the module sounddevice: one device, whose samples are kept."""

    PortAudioError = PortAudioError

    def __init__(self):
        self.name = "Fake Audio 192"
        self.blocks = []
        self.active = self.stuck = self.underflow = self.unstoppable = False
        self.opened = None
        self.refuses = None

    def query_devices(self, device, kind):
        if device == "none":
            raise ValueError("No output device matching 'none'")
        assert kind == "output"
        return {"name": self.name}

    def RawOutputStream(self, **options):
        if self.refuses:
            raise PortAudioError(self.refuses)
        self.opened = options
        return self

    latency = 0.01

    def start(self):
        self.active = True

    def abort(self):
        if self.unstoppable:
            raise PortAudioError("Unanticipated host error")
        self.active = False

    def close(self, *, ignore_errors):
        assert ignore_errors
        self.active = False

    def pass_s(self, duration_s):
        """Ask for the samples of so much time."""
        if not self.active or self.stuck:
            return
        for _ in range(max(round(duration_s * RATE_HZ / BLOCK), 1)):
            block = np.full((BLOCK, 2), 9, np.float32)
            status = SimpleNamespace(output_underflow=self.underflow)
            self.opened["callback"](memoryview(block.reshape(-1)), BLOCK, None, status)
            self.blocks.append(block)

    @property
    def played(self):
        return np.concatenate(self.blocks)

    def amplitude(self, channel=0):
        """Of the last periods."""
        return float(np.abs(self.blocks[-1][-64:, channel]).max())


class CardClock(VirtualClock):
    """Time in which the card plays."""

    def __init__(self, card):
        super().__init__()
        self.card = card

    def sleep(self, duration_s):
        super().sleep(duration_s)
        self.card.pass_s(duration_s)


@pytest.fixture
def card(monkeypatch):
    card = Card()
    monkeypatch.setitem(sys.modules, "sounddevice", card)
    return card


@pytest.fixture
def calibration(tmp_path):
    path = tmp_path / "plate.toml"

    def measure(frequency_hz, voltage_v):
        detuning = 2 * 60 * (frequency_hz - RESONANCE_HZ) / RESONANCE_HZ
        return UM_PP_PER_V * voltage_v / math.hypot(1, detuning)

    made = calibration_from(
        sweep(SweepPlan(centre_hz=RESONANCE_HZ), measure),
        device=Device(backend="sound", serial="Fake Audio 192, channel 1"),
        made=Provenance(date=datetime.now(tz=UTC).date(), by="A. Test", instrument="none"),
        drive=DriveChain(amplifier_gain=FULL_SCALE_V),
    )
    write_calibration(made, path)
    return path


@pytest.fixture
def plate(card, calibration):
    plate = open_plate(f"sound:3,calibration={calibration}", clock=VirtualClock())
    plate._machine = CardClock(card)
    yield plate
    card.stuck = card.unstoppable = False
    plate.close()


def test_a_surface_has_the_calibrations_volts_and_frequency(card, plate):
    with plate:
        presentation = plate.present(SURFACE)
        assert card.opened["device"] == 3
        assert card.opened["samplerate"] == RATE_HZ
        assert presentation.readback.kind == "applied"
        assert presentation.readback.level == pytest.approx(1.2)
        wanted = 1.2 / UM_PP_PER_V / FULL_SCALE_V
        last = card.played[-2048:, 0].astype(float)
        times_s = np.arange(2048) / RATE_HZ
        turns = np.exp(-2j * np.pi * RESONANCE_HZ * times_s)
        assert 2 * abs((last * turns).mean()) == pytest.approx(wanted, rel=0.01)
        assert np.abs(card.played[:, 1]).max() == 0
    assert card.amplitude() == 0


def test_the_other_channel_is_the_one_that_is_silent(card, calibration):
    made = read_calibration(calibration)
    device = made.device.model_copy(update={"serial": "Fake Audio 192, channel 2"})
    write_calibration(made.model_copy(update={"device": device}), calibration)
    plate = open_plate(f"sound:3,channel=2,calibration={calibration}", clock=VirtualClock())
    plate._machine = CardClock(card)
    with plate:
        plate.present(SURFACE)
        assert np.abs(card.played[:, 0]).max() == 0
        assert card.amplitude(1) > 0.3


@pytest.mark.parametrize(
    "name, noted", [("pulse", True), ("default", True), ("USB Audio (hw:1,0)", False)]
)
def test_a_device_whose_output_the_sound_server_can_move_is_noted(card, name, noted):
    card.name = name
    with open_plate("sound:3,full_scale=20", clock=VirtualClock()) as plate:
        assert [f"sound device '{name}' belongs" in note for note in plate.notes] == [True] * noted


def test_silence_is_on_the_wire_when_silence_returns(card, plate):
    with plate:
        plate.present(SURFACE)
        assert card.amplitude() > 0.3
        plate.silence()
        assert card.amplitude() == 0
        plate.present(SURFACE)
        plate.present(VirtualSurface(level=0.0))
        assert card.amplitude() == 0


@given(st.lists(st.tuples(st.floats(0, 1), st.integers(0, 3000)), min_size=1, max_size=6))
def test_the_carrier_never_steps(changes):
    carrier = Carrier(RATE_HZ)
    carrier.frequency_hz = RESONANCE_HZ
    levels = [0.0]
    for target, count in changes:
        carrier.target = target
        made = carrier.samples(count)
        assert made.shape == (count,)
        assert np.abs(made).max(initial=0) <= 1
        assert abs(carrier.level - levels[-1]) <= count / (RAMP_S * RATE_HZ) + 1e-9
        levels.append(carrier.level)


def test_blocks_of_any_size_make_one_sine():
    whole, parts = Carrier(RATE_HZ), Carrier(RATE_HZ)
    for each in (whole, parts):
        each.frequency_hz, each.target = RESONANCE_HZ, 0.7
    pieces = [parts.samples(count) for count in (1, 700, 0, 33, 4266)]
    assert np.concatenate(pieces) == pytest.approx(whole.samples(5000), abs=1e-6)


@pytest.mark.parametrize(
    "happens, fault",
    [
        ({"underflow": True}, PlateBusy),
        ({"active": False}, ConnectionLost),
    ],
)
def test_what_happens_to_the_device_comes_up_at_the_next_check(card, plate, happens, fault):
    plate.connect()
    plate.present(SURFACE)
    for name, value in happens.items():
        setattr(card, name, value)
    card.pass_s(0.01)
    with pytest.raises(fault):
        plate.check()
    assert not card.active or card.amplitude() == 0
    card.underflow = False
    plate.close()
    plate.connect()
    plate.present(SURFACE)
    assert card.amplitude() > 0.3


def test_a_device_that_asks_for_no_more_samples_is_stopped(card, plate):
    plate.connect()
    plate.present(SURFACE)
    card.stuck = True
    plate.silence()
    assert not card.active


def test_a_device_that_cannot_be_stopped_is_told_to_vibrate(card, plate):
    plate.connect()
    plate.present(SURFACE)
    card.stuck = card.unstoppable = True
    for attempt in (plate.silence, plate.close, plate.close):
        with pytest.raises(StillVibrating, match="could not be stopped"):
            attempt()
    card.stuck = card.unstoppable = False
    plate.connect()
    plate.close()


def test_a_session_that_hangs_lets_the_carrier_fall_silent_and_is_told(card, plate):
    with plate:
        plate.present(SURFACE)
        for _ in range(45):
            plate._machine.sleep(0.1)
            plate.check()
        assert card.amplitude() > 0.3
        plate._machine.sleep(5.2)
        assert card.amplitude() == 0
        with pytest.raises(PlateTimeout, match="no command for 5 s"):
            plate.check()


def test_a_pause_longer_than_the_attention_time_is_no_hang_while_the_card_is_silent(card, plate):
    with plate:
        plate._machine.sleep(5.2)  # before the first surface
        plate.present(SURFACE)
        plate.silence()
        plate._machine.sleep(60)
        plate.check()
        plate._machine.sleep(60)
        plate.present(SURFACE)
        assert card.amplitude() > 0.3


def test_what_the_card_cannot_supply_is_refused_before_the_session(card, tmp_path, monkeypatch):
    weak = SoundCard(
        "3",
        clock=VirtualClock(),
        full_scale_v=10.0,
        drive=DriveOfLevel(frequency_hz=30_500.0, level_per_v=UM_PP_PER_V, settling_s=0.01),
    )
    weak._machine = CardClock(card)
    assert weak.check_supported(VirtualSurface(level=1.5)) is None
    with pytest.raises(OverLimit, match="more than the card's full scale, 10 V"):
        weak.check_supported(VirtualSurface(level=2.3))
    weak.limits = replace(weak.limits, voltage_v=9.0)
    with pytest.raises(OverLimit, match=r"drive voltage 9\.78261 V peak at the plate is outside"):
        weak.check_supported(VirtualSurface(level=1.5))


def fails(plate):
    with plate:
        plate.present(SURFACE)
        raise ZeroDivisionError


def test_an_error_in_a_session_ends_silent(card, plate):
    with pytest.raises(ZeroDivisionError):
        fails(plate)
    assert card.amplitude() == 0
    assert not card.active


def test_excitation_is_held_to_the_cards_full_scale_and_the_plates_limits(card):
    plate = open_plate("sound:3,full_scale=10", clock=VirtualClock())
    plate._machine = CardClock(card)
    with plate:
        assert plate.excite(frequency_hz=30_000, voltage_v=5).kind == "none"
        assert card.amplitude() == pytest.approx(0.5, rel=0.05)
        with pytest.raises(OverLimit, match="more than the card's full scale, 10 V"):
            plate.excite(frequency_hz=30_000, voltage_v=12)
        assert card.amplitude() == 0
        with pytest.raises(OverLimit):
            plate.excite(frequency_hz=30_000, voltage_v=17)


def test_what_a_rate_cannot_carry_is_refused():
    with pytest.raises(UserError, match="rate is 48000 Hz, which supports at most 21600 Hz"):
        open_plate("sound:3,full_scale=10,rate=48000", clock=VirtualClock())
    slow = open_plate("sound:3,full_scale=10,rate=64000", clock=VirtualClock())
    assert slow.limits.frequency_max_hz == 28_800


@pytest.mark.parametrize(
    "address, why",
    [
        ("", "expected sound:DEVICE"),
        ("3", "set the peak voltage at full scale in the SPEC, for example full_scale=20"),
        ("3,full_scale=0", "expected a number above 0"),
        ("3,channel=3,full_scale=1", "expected 1 or 2"),
        ("3,attention=-1,full_scale=1", "attention is '-1', expected a number, 0 or more"),
    ],
)
def test_an_address_that_does_not_suffice_is_refused(address, why):
    with pytest.raises(UserError, match=why):
        open_plate(f"sound:{address}", clock=VirtualClock())


def test_another_full_scale_than_the_calibrations_is_refused(calibration):
    with pytest.raises(
        UserError, match=r"two different values .*: the SPEC has 10, the calibration"
    ):
        open_plate(f"sound:3,full_scale=10,calibration={calibration}", clock=VirtualClock())


def test_a_device_that_is_not_there_or_refuses_the_rate_is_told(card):
    with pytest.raises(PlateNotFound, match="'none': it cannot be opened"):
        open_plate("sound:none,full_scale=10", clock=VirtualClock()).connect()
    card.refuses = "Invalid sample rate"
    with pytest.raises(PlateNotFound, match=r"2 channels at 192000 Hz \(Invalid sample rate\)"):
        open_plate("sound:3,full_scale=10", clock=VirtualClock()).connect()


def test_a_texture_is_refused(card, plate):
    with plate, pytest.raises(UserError, match="cannot present the texture"):
        plate.present(Grating(spatial_period_mm=2.5, mean_level=1.2, depth_level=0.8, label="T1"))


def test_options_are_read():
    assert split_address("USB,full_scale=9,rate=96000", OPTIONS)[1]["rate"] == 96_000


@pytest.mark.parametrize("name, channel", [("Other Audio", 1), ("Fake Audio 192", 2)])
def test_a_calibration_of_another_card_or_channel_is_refused(card, calibration, name, channel):
    card.query_devices = lambda *_, **__: {"name": name}
    address = f"sound:3,calibration={calibration},channel={channel}"
    plate = open_plate(address, clock=VirtualClock())
    plate._machine = CardClock(card)
    made_on, here = "Fake Audio 192, channel 1", f"{name}, channel {channel}"
    with pytest.raises(WrongDevice, match=f"on device '{made_on}', but this is '{here}'"):
        plate.connect()
    assert plate.output is not Output.MAY_BE_ON


def test_a_card_that_went_away_while_it_played_is_not_confirmed_off(card, plate):
    plate.connect()
    plate.present(SURFACE)
    card.active = False
    with pytest.raises(ConnectionLost):
        plate.check()
    assert plate.output is Output.UNREACHABLE
