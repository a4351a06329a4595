"""What the interface promises for every backend, tried on one that only records."""

import math
from dataclasses import replace
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.faults import UserError
from slipscale.hardware.address import Plate
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.driver import PlateDriver
from slipscale.hardware.errors import (
    ConnectionLost,
    Frozen,
    NotReached,
    OffCalibration,
    OverLimit,
    PlateRefused,
    PlateTimeout,
    StillVibrating,
    WrongDevice,
)
from slipscale.hardware.limits import OnTime, PlateLimits
from slipscale.hardware.records import Output, PlateIdentity, Presentation, Readback
from slipscale.hardware.registry import backend_names, open_plate
from slipscale.stimuli.modulation import DEFAULT_MODULATOR
from slipscale.stimuli.surface import VirtualSurface
from slipscale.stimuli.texture import Grating


class Recorder(PlateDriver):
    """A backend that does what it is told and writes it down."""

    name = "recorder"
    serial = "1"
    frozen_s = math.inf  # Most tests do not check while time passes.

    def __init__(self, **options):
        super().__init__(clock=VirtualClock(), **options)
        self.heard = []
        self.amplitude_um_pp = 0.0
        self.fails_at = {}
        self.measures = lambda commanded: commanded

    def _hear(self, command):
        self.heard.append(command)
        if command in self.fails_at:
            raise self.fails_at[command]

    def _connect(self):
        self._hear("connect")
        return PlateIdentity(manufacturer="m", model="m", serial=self.serial, firmware="1")

    def _drive(self, amplitude_um_pp):
        self._hear("drive")
        self.amplitude_um_pp = amplitude_um_pp
        return Presentation(
            commanded_level=amplitude_um_pp,
            readback=self._read_back(),
            settled_by="readback",
            settle_time_s=0.0,
        )

    def _read_back(self):
        self._hear("read_back")
        return Readback(
            level=self.measures(self.amplitude_um_pp),
            kind="measured",
            time_s=self.clock.now(),
        )

    def _silence(self):
        self._hear("silence")
        self.amplitude_um_pp = 0.0

    def _close(self):
        self._hear("close")


def surface(amplitude_um_pp):
    return VirtualSurface(level=amplitude_um_pp)


@pytest.fixture
def plate():
    plate = Recorder()
    plate.connect()
    return plate


def test_a_command_outside_the_limits_never_reaches_the_backend_and_changes_nothing(plate):
    plate.present(surface(1.2))
    before = list(plate.heard)
    with pytest.raises(OverLimit, match=r"2\.6 µm p-p is outside 0 to 2\.5"):
        plate.present(surface(2.6))
    assert plate.heard == before
    assert plate.amplitude_um_pp == 1.2


@given(value=st.one_of(st.just(math.nan), st.just(math.inf), st.floats(max_value=-1e-9)))
def test_no_impossible_number_passes_any_limit(value):
    limits = PlateLimits()
    for check in (limits.check_level, limits.check_voltage, limits.check_frequency):
        with pytest.raises(OverLimit):
            check(value)


@pytest.mark.parametrize(
    "drive",
    [
        {"frequency_hz": 24_999.0, "voltage_v": 1.0},
        {"frequency_hz": math.nan, "voltage_v": 1.0},
        {"frequency_hz": 30_500.0, "voltage_v": 16.6},
        {"frequency_hz": 30_500.0, "voltage_v": math.nan},
    ],
)
def test_frequency_and_voltage_are_limited_too(plate, drive):
    before = list(plate.heard)
    with pytest.raises(OverLimit):
        plate.excite(**drive)
    assert plate.heard == before


CALIBRATION = SimpleNamespace(
    resonance=SimpleNamespace(quality_factor=600, frequency_hz=30_500),
    narrow=lambda limits: limits,
    voltage_v_peak=lambda um_pp: 60 * um_pp,
    mismatches=lambda *_, **__: (),
    check_date=lambda _: None,
    notes=lambda _: (),
)


class Ringing(Recorder):
    """A plate that rings down after its drive is off, as long as its Q makes it."""

    def __init__(self, *, time_constant_s, **options):
        super().__init__(**options)
        self.time_constant_s = time_constant_s
        self.off_s = None
        self.measures = self.ring

    def _silence(self):
        super()._silence()
        self.off_s = self.clock.now()

    def _drive(self, amplitude_um_pp):
        if amplitude_um_pp > 0:
            self.off_s = None
        return super()._drive(amplitude_um_pp)

    def ring(self, commanded_um_pp):
        if self.off_s is None:
            return commanded_um_pp
        return 2.3 * math.exp(-(self.clock.now() - self.off_s) / self.time_constant_s)


@pytest.mark.parametrize("time_constant_s", [0.0006, 0.01])
def test_no_vibration_directly_after_a_silence_waits_until_the_plate_has_rung_down(time_constant_s):
    plate = Ringing(time_constant_s=time_constant_s)
    plate.connect()
    for _ in range(3):
        plate.present(surface(2.3))
        plate.silence()
        made = plate.present(surface(0))
        assert made.readback.level < plate.limits.deviation_level
        assert made.settle_time_s > 0


def test_the_wait_for_a_ring_down_follows_from_the_plates_own_q():
    plate = Ringing(time_constant_s=600 / (math.pi * 30_500), plate=Plate(calibration=CALIBRATION))
    plate.connect()
    plate.silence()
    began_s = plate.clock.now()
    plate.present(surface(0))
    assert plate.clock.now() - began_s == pytest.approx(7 * 600 / (math.pi * 30_500))
    unknown = Ringing(time_constant_s=0.0006)
    unknown.connect()
    unknown.silence()
    began_s = unknown.clock.now()
    unknown.present(surface(0))
    assert unknown.clock.now() - began_s == pytest.approx(7 * 0.01)  # a Q of 1,000


def test_a_plate_that_is_driven_when_it_should_be_off_is_still_a_fault():
    plate = Ringing(time_constant_s=math.inf)
    plate.connect()
    plate.silence()
    with pytest.raises(NotReached):
        plate.present(surface(0))


def test_a_backend_without_open_loop_drive_says_so(plate):
    with pytest.raises(PlateRefused, match="does not accept frequencies and voltages"):
        plate.excite(frequency_hz=30_500.0, voltage_v=1.0)


@pytest.mark.parametrize("command", ["drive", "read_back"])
@pytest.mark.parametrize("error", [PlateTimeout("no answer"), KeyboardInterrupt(), ValueError()])
def test_any_error_in_a_command_silences_the_plate(plate, command, error):
    plate.fails_at[command] = error
    with pytest.raises(type(error)):
        plate.present(surface(1.2))
    assert plate.heard[-1] == "silence"
    assert plate.amplitude_um_pp == 0


def test_the_context_manager_ends_silent_on_an_exception_of_the_caller():
    def session(plate):
        with plate:
            plate.present(surface(2.3))
            raise ZeroDivisionError

    plate = Recorder()
    with pytest.raises(ZeroDivisionError):
        session(plate)
    assert plate.heard[-2:] == ["silence", "close"]


def test_a_connect_that_fails_lets_go_of_the_device():
    plate = Recorder()
    plate.fails_at["connect"] = PlateTimeout("no answer")
    with pytest.raises(PlateTimeout):
        plate.connect()
    assert plate.heard[-1] == "close"


def test_a_measured_amplitude_other_than_commanded_is_a_fault_and_ends_silent(plate):
    plate.measures = lambda commanded: 0.9 * commanded
    with pytest.raises(
        NotReached, match=r"2\.3 µm p-p was commanded, but 2\.070 µm p-p was measured"
    ):
        plate.present(surface(2.3))
    assert plate.amplitude_um_pp == 0


def test_a_measured_amplitude_within_tolerance_is_accepted(plate):
    plate.measures = lambda commanded: 0.96 * commanded + 0.001
    assert plate.present(surface(2.3)).readback.level == pytest.approx(2.209)


def test_silence_that_is_not_confirmed_is_told_once(plate):
    plate.fails_at["silence"] = PlateTimeout("no answer")
    with pytest.raises(PlateTimeout):
        plate.silence()
    plate.silence()
    plate.close()


def test_that_the_plate_may_still_vibrate_is_told_at_every_attempt_until_it_is_off(plate):
    plate.present(VirtualSurface(level=1.2))
    plate.fails_at["silence"] = StillVibrating("the output could not be switched off")
    for attempt in (plate.silence, plate.silence, plate.close, plate.close, plate.connect):
        if attempt == plate.connect:
            plate.fails_at["connect"] = PlateTimeout("no answer")
        with pytest.raises(StillVibrating, match="Take the finger off"):
            attempt()
    plate.fails_at = {}
    plate.close()


def test_a_fault_in_a_command_is_not_hidden_by_the_silence_that_fails_after_it(plate):
    plate.fails_at = {"drive": PlateRefused("too warm"), "silence": PlateTimeout("no answer")}
    with pytest.raises(PlateRefused):
        plate.present(surface(1.2))


def test_a_plate_that_was_forgotten_is_silenced(plate):
    plate.present(surface(1.2))
    plate.clock.sleep(plate.limits.on_time_s)
    plate.check()
    plate.clock.sleep(0.1)
    with pytest.raises(OverLimit, match="without a new command"):
        plate.check()
    assert plate.amplitude_um_pp == 0


def test_a_new_presentation_or_a_silent_plate_is_not_forgotten(plate):
    for _ in range(3):
        plate.present(surface(1.2))
        plate.clock.sleep(500)
        plate.check()
    plate.present(surface(0))
    plate.clock.sleep(10_000)
    plate.check()


def test_duty_over_its_limit_is_refused_until_the_plate_has_rested():
    plate = Recorder(plate=Plate(limits=PlateLimits(duty=0.5, duty_window_s=100)))
    plate.connect()
    plate.clock.sleep(1_000)
    plate.present(surface(1.2))
    plate.clock.sleep(50)
    plate.check()
    plate.clock.sleep(1)
    with pytest.raises(OverLimit, match="51% of the last 100 s"):
        plate.check()
    assert plate.amplitude_um_pp == 0
    with pytest.raises(OverLimit):
        plate.present(surface(1.2))
    plate.present(surface(0))
    plate.clock.sleep(51)
    plate.present(surface(1.2))


@given(
    spans=st.lists(st.tuples(st.floats(0.1, 50), st.floats(0.1, 50)), max_size=12),
    window_s=st.floats(1, 100),
)
def test_duty_agrees_with_counting_the_window_tick_by_tick(spans, window_s):
    on_time, now_s, on = OnTime(window_s=window_s), 0.0, []
    for on_s, off_s in spans:
        on_time.command(now_s, vibrates=True)
        on.append((now_s, now_s + on_s))
        on_time.command(now_s + on_s, vibrates=False)
        now_s += on_s + off_s
    ticks = [now_s - window_s * (i + 0.5) / 2000 for i in range(2000)]
    counted = sum(any(a <= t < b for a, b in on) for t in ticks) / 2000
    assert on_time.duty(now_s) == pytest.approx(counted, abs=0.02)


@pytest.mark.parametrize(
    "wrong",
    [
        {"level": math.nan},
        {"duty": 1.5},
        {"voltage_v": -1.0},
        {"frequency_min_hz": 5e4},
    ],
)
def test_impossible_limits_are_refused(wrong):
    with pytest.raises(UserError, match=next(iter(wrong))):
        PlateLimits(**wrong)


def test_every_fault_tells_what_to_do_about_it():
    error = PlateTimeout("no answer from /dev/ttyACM0")
    assert str(error) == (
        "no answer from /dev/ttyACM0. Check that the device has power and that no other program "
        "uses it, then unplug and replug it."
    )


def test_an_unknown_backend_is_refused_with_those_there_are():
    with pytest.raises(UserError, match=r"unknown backend 'mokc'; expected one of (daq, )?mock"):
        open_plate("mokc", clock=VirtualClock())


def test_the_mock_is_found_by_entry_point():
    assert "mock" in backend_names()
    assert open_plate("mock", clock=VirtualClock()).name == "mock"


# The state of the output.


def state_of(plate):
    return plate.output


def test_the_output_is_unreachable_until_a_device_has_confirmed_that_it_is_off():
    plate = Recorder()
    assert state_of(plate) is Output.UNREACHABLE
    with pytest.raises(ConnectionLost, match="not connected"):
        plate.present(surface(1.2))
    assert plate.heard == []
    plate.connect()
    assert state_of(plate) is Output.OFF
    plate.present(surface(1.2))
    assert state_of(plate) is Output.MAY_BE_ON
    plate.present(surface(0))
    assert state_of(plate) is Output.OFF
    plate.close()
    assert state_of(plate) is Output.OFF


def test_a_command_outside_the_limits_leaves_the_output_as_it_was(plate):
    for amplitude_um_pp, state in ((0, Output.OFF), (1.2, Output.MAY_BE_ON)):
        plate.present(surface(amplitude_um_pp))
        with pytest.raises(OverLimit):
            plate.present(surface(2.6))
        assert state_of(plate) is state


def test_an_output_that_was_not_confirmed_off_presents_nothing_before_it_is_connected(plate):
    plate.present(surface(1.2))
    plate.fails_at["silence"] = PlateTimeout("no answer")
    with pytest.raises(PlateTimeout):
        plate.silence()
    assert state_of(plate) is Output.UNREACHABLE
    plate.fails_at.clear()
    with pytest.raises(ConnectionLost):
        plate.present(surface(1.2))
    plate.silence()
    assert state_of(plate) is Output.OFF
    plate.present(surface(1.2))


def test_a_plate_that_is_off_follows_nothing(plate):
    plate._follow = plate.heard.append
    plate.silence()
    with pytest.raises(PlateRefused, match="its output is confirmed off, so it cannot follow"):
        plate.follow(1.0)
    assert 1.0 not in plate.heard


class Applied(Recorder):
    """A backend that computes its amplitude from the drive that is on."""

    def _read_back(self):
        return replace(super()._read_back(), kind="applied")


@pytest.mark.parametrize("commanded, applied", [(1.2, 0.6), (0.02, 0.04), (1.2, 1.22)])
def test_an_applied_amplitude_is_held_to_one_per_cent(commanded, applied):
    plate = Applied()
    plate.measures = lambda _: applied
    plate.connect()
    with pytest.raises(NotReached, match="was applied"):
        plate.present(surface(commanded))
    assert state_of(plate) is Output.OFF


def test_an_applied_amplitude_is_accepted_within_one_per_cent_and_rounding():
    limits = PlateLimits(level=0.5)
    limits.check_reached(0.0, 3.9e-7 * 0.5, applied=True)
    with pytest.raises(NotReached, match="was applied"):
        limits.check_reached(0.0, 4.1e-7 * 0.5, applied=True)


def test_a_check_asks_the_device_and_silences_the_plate_at_its_fault(plate, monkeypatch):
    plate.present(surface(1.2))

    def lost():
        raise ConnectionLost("the line is gone")

    monkeypatch.setattr(plate, "_check", lost)
    with pytest.raises(ConnectionLost):
        plate.check()
    assert plate.heard[-1] == "silence"


class Powered(Recorder):
    """A backend that reports its drive voltage."""

    voltage_v = 0.0

    def _read_back(self):
        return replace(super()._read_back(), voltage_v_peak=self.voltage_v)


@pytest.mark.parametrize("factor, accepted", [(2.0, False), (0.5, False), (1.2, True)])
def test_a_voltage_that_the_calibration_does_not_predict_is_a_fault(factor, accepted):
    """A sensor at half of its sensitivity: 1.2 µm reported, 2.4 µm true, at twice the voltage."""
    plate = Powered(plate=Plate(calibration=CALIBRATION))
    plate.voltage_v = 1.2 * 60 * factor
    plate.connect()
    if accepted:
        assert plate.present(surface(1.2)).predicted_v_peak == 72
        return
    with pytest.raises(OffCalibration, match=r"predicts 72\.00 V") as fault:
        plate.present(surface(1.2))
    assert state_of(plate) is Output.OFF
    assert "1.2" not in str(fault.value.blinded())


class Follower(Recorder):
    """A backend that follows, and plays no lists."""

    follow_lag_s = 0.02


def test_a_backend_that_follows_needs_no_modulator_where_the_fingers_place_is_known():
    texture = Grating(
        spatial_period_mm=2.5, mean_level=1.2, depth_level=0.8, waveform="square", label="T1",
        finger_speed_mm_s=50,
    )  # fmt: skip
    plate = Follower()
    assert plate.check_supported(texture, sensors=["position"]) is None
    with pytest.raises(UserError, match=r"name a finger-position sensor"):
        plate.check_supported(texture)
    with pytest.raises(UserError, match="can only hold a constant amplitude"):
        Recorder().check_supported(texture, sensors=["position"])
    wide = replace(texture, mean_level=2.0, depth_level=0.8)
    with pytest.raises(OverLimit):
        plate.check_supported(wide, sensors=["position"])


class Modulating(Recorder):
    """A recorder that plays textures, and follows."""

    modulator = DEFAULT_MODULATOR
    follow_lag_s = 0.01

    def _play(self, loop):
        self.heard.append(("play", max(loop.levels)))

    def _follow(self, amplitude_um_pp):
        self.heard.append(("follow", amplitude_um_pp))


def ridges(mean_um_pp, depth_um_pp):
    return Grating(
        spatial_period_mm=2.5,
        mean_level=mean_um_pp,
        depth_level=depth_um_pp,
        waveform="square",
        finger_speed_mm_s=50,
    )


def test_a_texture_is_driven_at_its_mean_and_then_played():
    with Modulating() as plate:
        plate.heard.clear()
        presented = plate.present(ridges(1.2, 0.8))
    assert plate.heard[:3] == ["drive", "read_back", ("play", pytest.approx(2.0))]
    assert presented.commanded_level == 1.2


def test_a_texture_whose_ridges_are_beyond_the_limits_never_reaches_the_backend():
    with Modulating() as plate:
        plate.heard.clear()
        with pytest.raises(OverLimit, match=r"2\.6 µm p-p is outside 0 to 2\.5"):
            plate.present(ridges(2.0, 0.6))
        assert plate.heard == []


def test_a_plate_that_vibrates_follows_within_its_limits():
    with Modulating() as plate:
        plate.present(surface(1.2))
        plate.heard.clear()
        plate.follow(0.4)
        with pytest.raises(OverLimit, match=r"2\.6 µm p-p is outside 0 to 2\.5"):
            plate.follow(2.6)
        assert plate.heard == [("follow", 0.4)]


def test_a_plate_that_is_not_connected_reads_nothing_back():
    plate = Recorder()
    with pytest.raises(ConnectionLost, match="not connected"):
        plate.read_back()
    assert plate.heard == []


def test_what_a_plate_without_a_reading_vibrates_is_0(plate):
    plate.measures = lambda _: None
    assert plate.vibration_level() == 0


@pytest.fixture
def watched(plate):
    """A plate that is on, and whose session checks it."""
    plate.frozen_s = PlateDriver.frozen_s
    plate.present(surface(1.2))
    return plate


@pytest.mark.parametrize("stands_still", ["sleep", "suspend"])
def test_a_computer_that_stood_still_while_the_plate_was_on_is_a_fault(watched, stands_still):
    for _ in range(100):  # A session checks in every frame.
        watched.clock.sleep(0.9)
        watched.check()
    getattr(watched.clock, stands_still)(20.0)
    with pytest.raises(Frozen, match=r"stood still for 20\.0 s while the plate was on"):
        watched.check()
    assert watched.output is Output.OFF
    assert watched.heard[-1] == "silence"
    watched.present(surface(1.2))  # Nothing is left of the fault.
    watched.check()


def test_a_computer_that_stood_still_is_a_fault_of_the_next_command_too(watched):
    watched.clock.suspend(1.1)
    with pytest.raises(Frozen, match=r"1\.1 s"):
        watched.read_back()


@pytest.mark.parametrize("change", [{"frozen_s": 30.0}, {"attention_s": 0.0}])
def test_a_longer_pause_is_allowed_by_declaration_or_without_attention(watched, change):
    vars(watched).update(change)
    watched.clock.sleep(20.0)
    watched.check()


def test_a_pause_while_the_plate_is_off_is_no_fault(watched):
    watched.silence()
    watched.clock.sleep(600.0)
    watched.check()
    watched.present(surface(1.2))


def test_the_limit_of_the_on_time_counts_the_time_of_a_suspended_computer(plate):
    plate.present(surface(1.2))
    plate.clock.sleep(1.0)
    plate.clock.suspend(plate.limits.on_time_s)
    with pytest.raises(OverLimit, match="vibrated for 600 s without a new command"):
        plate.check()


def test_another_device_at_the_same_port_is_not_taken_for_the_one_before():
    plate = Recorder()
    with plate:
        plate.present(VirtualSurface(level=1.2))
    plate.serial = "2"
    with pytest.raises(WrongDevice, match="began with device '1', but this is '2'"):
        plate.connect()
    assert plate.output is not Output.MAY_BE_ON
    plate.serial = "1"
    with plate:
        plate.present(VirtualSurface(level=1.2))
