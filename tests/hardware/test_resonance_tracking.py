"""Resonance tracking: three points find a resonance that moved, within bounds, and end silent."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.faults import UserError
from slipscale.hardware.address import DEFAULT_PLATE, Plate
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.calibration.record import Calibration
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.errors import ConnectionLost, OffCalibration, PlateRefused
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.plate.dynamics import Resonator
from slipscale.hardware.plate.twin import OFF, Twin
from slipscale.hardware.resonance_tracking import half_width_hz, track, vertex

CALIBRATED_HZ = 30_500.0


class Generator(MockPlate):
    """A plate that is driven where it is told, as by a generator."""

    tracks = True


def calibration(quality_factor=60.0):
    return Calibration.model_validate(
        {
            "device": {"serial": "twin", "backend": "mock"},
            "made": {"date": "2026-11-21", "by": "a test", "instrument": "none"},
            "drive": {},
            "resonance": {
                "frequency_hz": CALIBRATED_HZ, "frequency_ci95_hz": 1, "residual_um": 0,
                "quality_factor": quality_factor, "quality_factor_ci95": 1,
            },
            "gain": {
                "um_pp_per_v": 2.3 / 15, "um_pp_per_v_ci95": 0, "residual_um": 0,
                "voltage_max_v": 16.5, "amplitude_max_um_pp": 2.5,
            },
            "points": [{"sweep": "voltage", "frequency_hz": CALIBRATED_HZ, "voltage_v": 16.5,
                        "amplitude_um_pp": 2.5}],
        }
    )  # fmt: skip


def generator(resonance_hz, *, noise_um=0.0, limits=DEFAULT_PLATE.limits):
    twin = Twin(resonator=Resonator(resonance_hz=resonance_hz), noise_um=noise_um, seed=2)
    plate = Generator(
        clock=VirtualClock(), twin=twin, plate=Plate(calibration=calibration(), limits=limits)
    )
    plate.connect()
    return plate


def measured(plate):
    return lambda: plate.twin.measure_um_pp(plate.clock.now())


def true_hz(plate):
    return plate.twin.conditions(plate.clock.now()).resonance_hz


@given(st.floats(25_000, 40_000), st.floats(20, 500), st.floats(0.05, 3), st.floats(-0.9, 0.9))
def test_three_points_of_a_resonance_give_it(resonance_hz, quality_factor, top_um_pp, off):
    half = resonance_hz / (2 * quality_factor)

    def amplitude(f):
        return top_um_pp / math.hypot(1, (f - resonance_hz) / half)

    places = [resonance_hz + half * (off + each) for each in (-0.5, 0.0, 0.5)]
    found_hz, found_um_pp = vertex([(f, amplitude(f)) for f in places])
    assert found_hz == pytest.approx(resonance_hz, abs=1e-4 * half)
    assert found_um_pp == pytest.approx(top_um_pp, rel=1e-4)


@pytest.mark.parametrize("amplitudes", [(1, 0, 1), (1, 0.5, 1), (1, 1, 1), (1, float("nan"), 1)])
def test_points_on_no_resonance_are_refused(amplitudes):
    with pytest.raises(UserError):
        vertex(list(zip((30_400, 30_500, 30_600), amplitudes, strict=True)))


@pytest.mark.parametrize("moved_hz", [-80.0, -10.0, 0.0, 60.0])
def test_a_resonance_that_has_moved_is_found_and_driven_from_now_on(moved_hz):
    plate = generator(CALIBRATED_HZ + moved_hz)
    found = track(plate, measured(plate))
    assert found.refused == ""
    assert found.before_hz == CALIBRATED_HZ
    assert plate.tracked_hz == found.frequency_hz == pytest.approx(true_hz(plate), abs=1)
    assert track(plate, measured(plate)).before_hz == found.frequency_hz  # from there on


def test_the_half_width_is_where_the_amplitude_has_fallen_to_71_per_cent():
    assert half_width_hz(calibration(61.0).resonance) == pytest.approx(250.0)


def test_a_sensors_noise_moves_the_resonance_by_less_than_a_tenth_of_its_width():
    plate = generator(CALIBRATED_HZ, noise_um=0.005)
    found = track(plate, measured(plate))
    assert abs(found.frequency_hz - true_hz(plate)) < 0.1 * CALIBRATED_HZ / 60


def test_the_sweep_is_hardly_felt_and_ends_silent():
    plate = generator(CALIBRATED_HZ)
    found = track(plate, measured(plate))
    assert len(found.points) == 3
    assert max(amplitude for _, amplitude in found.points) < 0.35
    assert plate.twin.drive == OFF


@pytest.mark.parametrize("resonance_hz", [CALIBRATED_HZ - 400, CALIBRATED_HZ + 600])
def test_a_resonance_far_from_the_calibrated_one_is_not_believed(resonance_hz):
    plate = generator(resonance_hz)
    found = track(plate, measured(plate))
    assert "recalibrate" in found.refused
    assert found.frequency_hz == CALIBRATED_HZ
    assert plate.tracked_hz is None
    assert plate.twin.drive == OFF


def test_an_instrument_that_tells_nothing_changes_nothing():
    plate = generator(CALIBRATED_HZ)
    found = track(plate, lambda: 0.0)
    assert "amplitude of 0" in found.refused
    assert plate.tracked_hz is None


def test_the_plates_limits_hold_for_the_sweep():
    plate = generator(CALIBRATED_HZ, limits=PlateLimits(frequency_max_hz=30_550))
    with pytest.raises(Exception, match="drive frequency") as refused:
        track(plate, measured(plate))
    assert refused.value.code == "over_limit"
    assert plate.twin.drive == OFF


def test_a_line_that_is_lost_in_the_sweep_is_a_fault():
    plate = generator(CALIBRATED_HZ)
    plate.inject("lost", phase="present", n=2)
    with pytest.raises(ConnectionLost):
        track(plate, measured(plate))


def test_a_plate_that_follows_by_itself_is_not_tracked():
    with MockPlate(clock=VirtualClock()) as plate, pytest.raises(PlateRefused):
        track(plate, lambda: 1.0)


@pytest.mark.parametrize("gain", [0.5, 0.8, 1.3])
def test_a_plate_whose_gain_has_changed_is_a_fault_and_no_session_goes_on(gain):
    plate = generator(CALIBRATED_HZ + 20)
    with pytest.raises(OffCalibration, match=r"the calibration predicts 0\.300 µm p-p"):
        track(plate, lambda: gain * measured(plate)())
    assert plate.tracked_hz is None
    assert plate.twin.drive == OFF
