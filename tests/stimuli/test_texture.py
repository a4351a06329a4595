import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipscale.faults import UserError
from slipscale.stimuli.modulation import STEPS_MAX, AmplitudeStep, Loop, Modulator
from slipscale.stimuli.surface import VirtualSurface
from slipscale.stimuli.texture import Grating

WAVES = ["sine", "square", "triangle", "sawtooth"]


def grating(**changes):
    given_ = {"spatial_period_mm": 5.0, "mean_level": 1.0, "depth_level": 0.5, "label": "B"}
    return Grating(**given_ | changes)


@settings(deadline=None)
@given(
    wave=st.sampled_from(WAVES),
    mean=st.floats(0, 2),
    share=st.floats(0, 1),
    position=st.floats(-100, 100),
)
def test_amplitude_stays_between_mean_minus_and_plus_depth(wave, mean, share, position):
    surface = grating(mean_level=mean, depth_level=share * mean, waveform=wave)
    amplitude = surface.level_at(position)
    assert mean - share * mean - 1e-12 <= amplitude <= surface.level + 1e-12


@pytest.mark.parametrize("wave", WAVES)
def test_grating_repeats_after_its_period_and_has_its_mean(wave):
    surface = grating(waveform=wave)
    places = [(i + 0.5) * 5.0 / 1000 for i in range(1000)]
    first = [surface.level_at(x) for x in places]
    assert [surface.level_at(x + 5.0) for x in places] == pytest.approx(first)
    assert sum(first) / 1000 == pytest.approx(1.0, abs=1e-3)


def test_square_grating_switches_twice_a_period():
    steps = grating(waveform="square").envelope(50.0, 0.2)
    assert [s.level for s in steps] == [1.5, 0.5, 1.5, 0.5]
    assert [s.time_s for s in steps] == pytest.approx([0, 0.05, 0.1, 0.15])


@settings(deadline=None)
@given(
    wave=st.sampled_from(WAVES),
    speed=st.floats(1, 150) | st.floats(-150, -1),
    duration=st.floats(0.05, 1.0),
)
def test_commands_are_in_order_in_time_and_no_closer_than_the_line_allows(wave, speed, duration):
    modulator = Modulator()
    steps = grating(waveform=wave).envelope(speed, duration, modulator)
    times = [s.time_s for s in steps]
    assert times[0] == 0
    assert times[-1] < duration
    gaps = [b - a for a, b in pairwise(times)]
    assert all(gap >= modulator.command_interval_s - 1e-12 for gap in gaps)


def test_sampled_wave_follows_the_place_of_the_finger():
    surface = grating()
    steps = surface.envelope(40.0, 0.125)  # one period
    width = steps[1].time_s
    for time_s, amplitude in steps:
        expected = surface.level_at((time_s + width / 2) * 40.0)
        assert amplitude == pytest.approx(expected)


def test_backward_stroke_mirrors_the_forward_one():
    surface = grating(waveform="sawtooth")
    forward = [s.level for s in surface.envelope(40.0, 0.12)]
    backward = [s.level for s in surface.envelope(-40.0, 0.12)]
    assert [2 * surface.mean_level - a for a in forward] == pytest.approx(backward)


def test_finger_at_rest_and_flat_grating_take_one_command():
    assert grating().envelope(0.0, 1.0) == (AmplitudeStep(0.0, 1.0),)
    assert len(grating(depth_level=0.0).envelope(50.0, 1.0)) == 1


def test_bandwidth_is_half_the_resonance_over_q():
    modulator = Modulator()
    assert modulator.bandwidth_hz == pytest.approx(254.17, abs=0.01)
    assert modulator.time_constant_s * 2 * math.pi * modulator.bandwidth_hz == pytest.approx(1)
    assert modulator.passed(modulator.bandwidth_hz) == pytest.approx(math.sqrt(0.5))
    assert modulator.passed(0.0) == 1


def test_friction_follows_as_plate_and_film_do_in_series():
    modulator = Modulator(film_time_constant_s=0.006)
    film_hz = 1 / (2 * math.pi * 0.006)
    assert modulator.friction_passed(0.0) == 1
    assert modulator.friction_passed(film_hz) == pytest.approx(math.sqrt(0.5), rel=0.01)
    # The figures of docs/explanation/squeeze-film.md.
    assert modulator.friction_passed(16) == pytest.approx(0.855, abs=5e-4)
    assert modulator.friction_passed(254) == pytest.approx(0.0735, abs=5e-5)


def test_too_fast_a_finger_is_told_the_speed_and_period_that_would_do():
    with pytest.raises(UserError, match=r"texture 'B'.*up to 156 mm/s or a period from 16 mm"):
        grating().envelope(500.0, 1.0)


def test_plate_of_high_q_limits_what_a_fast_line_could_send():
    slow_plate = Modulator(quality_factor=6000.0, command_interval_s=1e-4)
    with pytest.raises(UserError, match=r"follow at most 2\.54"):
        grating(waveform="square").envelope(50.0, 1.0, slow_plate)


@pytest.mark.parametrize(
    "changes, said",
    [
        ({"spatial_period_mm": 0.0}, "spatial_period_mm is 0.0"),
        ({"spatial_period_mm": math.nan}, "spatial_period_mm is nan"),
        ({"mean_level": -1.0}, "mean is -1.0"),
        ({"depth_level": 1.5}, "depth must be at most the mean, .* but is 1.5"),
        ({"depth_level": math.nan}, "depth is nan"),
        ({"waveform": "noise"}, r"unknown waveform 'noise' \(expected one of: sine"),
        (
            {"third_harmonic_share": 0.5, "waveform": "square"},
            "only a sine can have harmonics, but waveform is 'square'",
        ),
        ({"third_harmonic_phase_deg": 9.0}, "is 0; expected third_harmonic_share above 0"),
        (
            {"second_harmonic_share": 1.0, "depth_level": 0.6},
            "depth must be at most 0.568126, but is 0.6",
        ),
    ],
)
def test_impossible_grating_is_refused(changes, said):
    with pytest.raises(UserError, match=said):
        grating(**changes)


@pytest.mark.parametrize("speed, duration", [(math.inf, 1.0), (10.0, 0.0), (10.0, math.nan)])
def test_impossible_stroke_is_refused(speed, duration):
    with pytest.raises(UserError, match="expected"):
        grating().envelope(speed, duration)


@pytest.mark.parametrize(
    "name", ["resonance_hz", "quality_factor", "command_interval_s", "shortest_edge_s"]
)
def test_impossible_modulator_is_refused(name):
    with pytest.raises(UserError, match=f"{name} must be a positive number, but is 0"):
        Modulator(**{name: 0.0})


def test_harmonics_add_to_a_sine_and_set_its_largest_and_smallest_amplitude():
    surface = grating(second_harmonic_share=0.5, second_harmonic_phase_deg=90.0)
    # sin x + cos(2x)/2 is 0.75 at 30° and -1.5 at 270°.
    assert surface.level == pytest.approx(1.375)
    assert surface.lowest_level == pytest.approx(0.25)
    assert surface.level_at(5.0 / 12) == pytest.approx(1.375)
    assert surface.level_at(0.75 * 5.0) == pytest.approx(0.25)
    played = surface.loop()
    assert len(played.levels) >= 16
    assert sum(played.levels) / len(played.levels) == pytest.approx(surface.mean_level)
    assert grating(second_harmonic_share=0.0) == grating()


def test_the_highest_harmonic_decides_what_plate_and_friction_follow():
    assert grating(finger_speed_mm_s=50.0).followed().change == "10 Hz at 50 mm/s"
    third = grating(third_harmonic_share=0.3, finger_speed_mm_s=50.0)
    assert third.followed().friction == pytest.approx(Modulator().friction_passed(30.0))
    with pytest.raises(UserError, match=r"follow at most 7\.81"):  # 32 steps of 4 ms
        grating(fourth_harmonic_share=0.1, finger_speed_mm_s=50.0).loop()


def test_the_plate_s_list_represents_harmonics_up_to_the_eighth():
    shares = {"fifth_harmonic_share": 0.2, "eighth_harmonic_share": 0.1}
    surface = grating(**shares, finger_speed_mm_s=19.0)  # 3.8 periods a second, 31 Hz
    played = surface.loop()
    assert len(played.levels) == STEPS_MAX
    spectrum = np.abs(np.fft.rfft(played.levels)) / (STEPS_MAX / 2)
    relative = spectrum[1:10] / spectrum[1]
    assert relative == pytest.approx([1, 0, 0, 0, 0.2, 0, 0, 0.1, 0], abs=1e-6)
    with pytest.raises(UserError, match=r"follow at most 3\.91"):
        grating(**shares, finger_speed_mm_s=20.0).loop()


@pytest.mark.parametrize("wave", WAVES)
def test_a_loop_goes_on_as_the_envelope_does(wave):
    surface = grating(waveform=wave, finger_speed_mm_s=40.0)
    loop = surface.loop()
    for i, step in enumerate(surface.envelope(40.0, 10 * 5.0 / 40.0)):
        assert loop.level(i) == pytest.approx(step.level)
        assert loop.step_at(step.time_s + loop.step_s / 2) == i
    assert sum(loop.levels) / len(loop.levels) == pytest.approx(loop.mean_level)
    assert max(loop.levels) <= surface.level
    assert min(loop.levels) >= surface.lowest_level


def test_a_surface_of_one_amplitude_has_nothing_to_play():
    assert VirtualSurface(level=1.5).loop() is None
    assert grating(depth_level=0.0).loop() is None


@pytest.mark.parametrize("speed", [0.0, -50.0, math.nan])
def test_a_texture_is_played_for_a_finger_that_moves_forward(speed):
    with pytest.raises(UserError, match="finger_speed_mm_s is"):
        grating(finger_speed_mm_s=speed)


def test_a_loop_faster_than_the_plate_is_refused():
    with pytest.raises(UserError, match=r"texture 'ridges'.*a period from 16 mm"):
        grating(name="ridges", finger_speed_mm_s=500.0).loop()


def loop(**changes):
    usual = {"levels": (0.5, 1.5), "step_s": 0.02, "edge_s": 0.002, "mean_level": 1.0}
    return Loop(**usual | changes)


@settings(deadline=None)
@given(time=st.floats(0, 10), depth=st.floats(0, 1))
def test_what_is_due_has_no_step_and_no_slope_beyond_the_edges(time, depth):
    played = loop(levels=(1 - depth, 1 + depth))
    later = 1e-5
    slope = abs(played.at_level(time + later) - played.at_level(time)) / later
    assert slope <= 2 * depth * math.pi / 2 / played.edge_s * (1 + 1e-6) + 1e-6
    assert 1 - depth - 1e-12 <= played.at_level(time) <= 1 + depth + 1e-12


def test_a_loop_begins_at_its_mean_and_then_goes_from_amplitude_to_amplitude():
    played = loop()
    times = (0.0, 0.001, 0.002, 0.019, 0.021, 0.03, 0.041)
    assert [played.at_level(t) for t in times] == pytest.approx([1, 0.75, 0.5, 0.5, 1, 1.5, 1])
    assert played.period_s == 0.04


@pytest.mark.parametrize(
    "changes, said",
    [
        ({"levels": (1.0,)}, "expected at least two levels, but found 1"),
        ({"levels": (1.0, math.nan)}, "but one is nan"),
        ({"mean_level": -1.0}, "but one is -1.0"),
        ({"edge_s": 0.0}, "edge_s must be above 0 .* but is 0.0 s"),
        ({"edge_s": 0.03}, r"at most step_s \(0.02 s\), but is 0.03 s"),
        ({"step_s": math.inf}, r"at most step_s \(inf s\)"),
    ],
)
def test_impossible_loop_is_refused(changes, said):
    with pytest.raises(UserError, match=said):
        loop(**changes)


def test_edges_take_three_time_constants_of_the_plate_and_bound_what_is_followed():
    assert Modulator().edge_s == 0.002  # three time constants are 1.88 ms
    ringing = Modulator(quality_factor=300.0)
    assert ringing.edge_s == pytest.approx(3 * ringing.time_constant_s)
    assert ringing.fastest_hz(8) == pytest.approx(1 / (8 * ringing.edge_s))
    played = grating(finger_speed_mm_s=60.0).loop(ringing)
    assert len(played.levels) == 8
    assert played.edge_s <= played.step_s
