"""A texture on a plate: played where the backend can, refused where it cannot."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from slipscale.faults import UserError
from slipscale.hardware.backends.function_generator import FunctionGenerator
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.errors import OverLimit
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.modulation import Loop
from slipscale.stimuli.surface import VirtualSurface
from slipscale.stimuli.texture import Grating


def grating(**changes):
    usual = {"spatial_period_mm": 5.0, "mean_level": 1.2, "depth_level": 0.8, "label": "T1"}
    return Grating(**usual | changes)


def connected(spec="mock", clock=None):
    plate = open_plate(spec, clock=clock or VirtualClock(), seed=3)
    plate.connect()
    return plate


def felt(plate, seconds=0.2, every_s=0.0005):
    readings = []
    for _ in range(round(seconds / every_s)):
        plate.clock.sleep(every_s)
        readings.append((plate.clock.now(), plate.vibration_level()))
    return np.array(readings).T


def test_a_finger_feels_the_wave_go_by():
    plate = connected()
    surface = grating()
    presentation = plate.present(surface)
    times_s, amplitudes = felt(plate)
    expected = [surface.level_at(t * surface.finger_speed_mm_s) for t in times_s]
    # Steps of 4 ms, edges of 2 ms, a ring of 0.6 ms: 10 Hz are passed but a little late.
    assert np.abs(amplitudes - expected).max() < 0.2
    assert amplitudes.mean() == pytest.approx(1.2, abs=0.01)
    assert presentation.commanded_level == 1.2
    assert presentation.readback.level == pytest.approx(1.2, abs=0.03)


def test_the_plate_rings_between_the_steps_as_its_equation_says():
    plate = connected("mock:q=300")
    surface = grating(waveform="square", finger_speed_mm_s=150.0)
    plate.present(surface)
    loop = surface.loop(plate.modulator)
    times_s, amplitudes = felt(plate, seconds=0.05)
    now = plate.twin.conditions(times_s[0])
    detuning_hz = plate.twin.resonator.resonance_hz - now.resonance_hz
    rate = 1 / now.time_constant_s + 2j * np.pi * detuning_hz
    # Forced to the commanded amplitude, with the phase that a drive off resonance has.
    steady = rate.conjugate() / abs(rate)

    def slope(t, envelope):
        return rate * (steady * loop.at_level(t) - envelope)

    begin_s = times_s[0] - 40 * now.time_constant_s
    solved = solve_ivp(
        slope,
        (begin_s, times_s[-1]),
        [1.2 + 0j],
        t_eval=times_s,
        max_step=loop.edge_s / 100,
        rtol=1e-8,
    )
    np.testing.assert_allclose(amplitudes, np.abs(solved.y[0]), atol=1e-4)


@pytest.mark.parametrize("spec, allowed_um", [("mock:noise=0", 1e-4), ("mock", 0.03)])
def test_what_is_read_back_of_a_texture_is_its_mean(spec, allowed_um):
    plate = connected(spec)
    plate.present(grating(mean_level=0.8, waveform="sawtooth"))
    for _ in range(50):
        plate.clock.sleep(0.0037)
        assert plate.read_back().level == pytest.approx(0.8, abs=allowed_um)


class OddSurface(VirtualSurface):
    """A laboratory's own, which plays what it likes."""

    def loop(self, modulator=None):  # noqa: ARG002 - whatever the plate follows
        return OddSurface.played


@pytest.mark.parametrize(
    "changes, kind, said",
    [
        ({"levels": (0.5, 2.6)}, OverLimit, r"2\.6"),
        ({"step_s": 0.003}, UserError, "step_s must be at least 0.004, but is 0.003"),
        ({"edge_s": 0.001}, UserError, "edge_s must be at least 0.002, but is 0.001"),
        ({"levels": (0.5,) * 65}, UserError, "expected at most 64 amplitudes, but found 65"),
    ],
)
def test_whoever_makes_the_loop_its_limits_are_the_plates(changes, kind, said):
    usual = {
        "levels": (0.5, 1.5),
        "step_s": 0.02,
        "edge_s": 0.002,
        "mean_level": 1.0,
    }
    OddSurface.played = Loop(**usual | changes)
    plate = connected()
    with pytest.raises(kind, match=said):
        plate.present(OddSurface(level=1.5))
    assert plate.vibration_level() == 0


def test_what_is_felt_depends_on_the_time_alone():
    def reading(began_s, looks):
        clock = VirtualClock(began_s)
        plate = connected(clock=clock)
        plate.present(grating())
        for _ in range(looks):
            clock.sleep(0.003)
            plate.vibration_level()
        clock.set(7.3)
        return plate.vibration_level(), plate.read_back()

    first, *others = [reading(began_s, looks) for began_s, looks in ((0, 0), (2, 9), (8, 30))]
    for amplitude, readback in others:
        assert amplitude == pytest.approx(first[0], abs=1e-12)
        assert readback == first[1]


def test_the_next_command_ends_a_texture():
    plate = connected()
    plate.present(grating())
    plate.present(VirtualSurface(level=0.5))
    _, amplitudes = felt(plate)
    assert amplitudes == pytest.approx(0.5)
    plate.present(grating())
    plate.silence()
    plate.clock.sleep(0.1)
    assert plate.vibration_level() < 1e-9


def test_the_limit_holds_for_the_largest_amplitude_and_leaves_the_plate_as_it_was():
    plate = connected()
    plate.present(VirtualSurface(level=0.5))
    with pytest.raises(OverLimit, match=r"2\.6"):
        plate.present(grating(mean_level=1.8))
    assert plate.vibration_level() == pytest.approx(0.5)


def test_a_texture_too_fast_for_this_plate_is_refused_before_it_moves():
    plate = connected("mock:q=6000")
    with pytest.raises(UserError, match="the plate and its connection can follow"):
        plate.present(grating())
    assert plate.vibration_level() == 0


class OneAmplitude(MockPlate):
    """A backend that, as most do, says nothing of modulation."""

    name = "one amplitude"

    def __init__(self, **others):
        super().__init__(**others)
        self.modulator = None


def test_a_backend_that_cannot_modulate_refuses_and_leaves_the_plate_as_it_was():
    plate = OneAmplitude(clock=VirtualClock())
    plate.connect()
    plate.present(VirtualSurface(level=0.5))
    with pytest.raises(UserError, match="'one amplitude' cannot present the texture 'T1'"):
        plate.present(grating())
    assert plate.vibration_level() == pytest.approx(0.5)
    assert plate.present(grating(depth_level=0.0)).commanded_level == 1.2


def test_a_function_generator_does_not_claim_to_modulate():
    assert FunctionGenerator.modulator is None
