"""Speed, strokes and friction from samples: known ways and forces give known numbers."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.hardware.contact.measures import friction, movement
from slipscale.hardware.contact.source import Sample


def way(along_mm, rate_hz=100.0):
    """Return samples of places along x."""
    return [Sample(number / rate_hz, (x, 0.0)) for number, x in enumerate(along_mm)]


def to_and_fro(strokes, *, stroke_mm=40.0, speed_mm_s=60.0, rate_hz=100.0):
    """Return a finger of constant speed that turns at the ends of its strokes."""
    count = round(strokes * stroke_mm / speed_mm_s * rate_hz)
    gone = [number * speed_mm_s / rate_hz for number in range(count + 1)]
    return way([abs((g + stroke_mm) % (2 * stroke_mm) - stroke_mm) for g in gone], rate_hz)


@pytest.mark.parametrize("strokes", [1, 2, 7])
@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 1000.0])
def test_a_finger_that_goes_to_and_fro_has_its_strokes_and_speed(strokes, rate_hz):
    found = movement(to_and_fro(strokes, rate_hz=rate_hz))
    assert found.strokes == strokes
    assert found.speed_mm_s == pytest.approx(60.0, rel=0.05)  # a turn between two looks is cut


@given(st.lists(st.floats(-2.4, 2.4), min_size=2, max_size=300))
def test_a_tremble_is_no_stroke(noise):
    assert movement(way(noise)).strokes == 0


def test_noise_of_a_sensor_does_not_pass_for_speed():
    still = movement(way([0.02 * (-1) ** number for number in range(500)]))
    assert still.speed_mm_s < 1.0


def test_a_finger_that_was_lifted_did_not_go_the_way_between():
    before, after = way([0.0] * 50), way([80.0] * 50)
    later = [Sample(each.time_s + 5.0, each.values) for each in after]
    assert movement([*before, *later]).speed_mm_s == 0.0


def test_a_finger_that_was_never_seen_twice_has_no_speed():
    assert movement([]).speed_mm_s is None
    assert movement(way([1.0])).speed_mm_s is None


def pressed(coefficient, *, normal_n=0.5, count=200, rate_hz=100.0):
    """Return the forces of a finger that slides to and fro, once a second."""
    times = [number / rate_hz for number in range(count)]
    return [
        Sample(t, (normal_n, math.copysign(coefficient * normal_n, math.sin(2 * math.pi * t))))
        for t in times
    ]


@given(st.floats(0.0, 3.0), st.floats(0.06, 5.0))
def test_friction_is_the_coefficient_whatever_the_force_and_direction(coefficient, normal_n):
    found = friction(pressed(coefficient, normal_n=normal_n))
    assert found.coefficient == pytest.approx(coefficient, abs=1e-9)
    assert found.normal_n == pytest.approx(normal_n)


def test_what_was_measured_while_the_finger_rested_does_not_count():
    # It slides with 0.6, then rests with a lateral force that its muscles hold.
    slides = [Sample(n / 100, (0.5, 0.3)) for n in range(100)]
    rests = [Sample(1 + n / 100, (0.5, 0.05)) for n in range(300)]
    places = way([min(n, 100) * 0.6 for n in range(400)])
    assert friction([*slides, *rests]).coefficient == pytest.approx(0.1)
    assert friction([*slides, *rests], places).coefficient == pytest.approx(0.6)


def test_a_finger_off_the_plate_has_no_friction():
    assert friction([Sample(n / 100, (0.01, 0.2)) for n in range(100)]).coefficient is None
    assert friction([]).coefficient is None
