"""What no finger does: each rule, and that fingers do none of it."""

import math

import pytest

from slipscale.hardware.contact.plausibility import implausible_forces, implausible_places
from slipscale.hardware.contact.serial_columns import numbers_of
from slipscale.hardware.contact.source import Sample


def sampled(values, *, rate_hz=100, duration_s=3.0):
    """Samples of a function of time."""
    times = [number / rate_hz for number in range(round(rate_hz * duration_s))]
    return [Sample(each, values(each)) for each in times]


def stroking(time_s):
    """Strokes of 60 mm within a second, with 20 µm of a laser's noise."""
    return 30 * math.sin(math.pi * time_s), 2 + 0.02 * math.sin(977 * time_s)


def pressing(time_s):
    normal = 0.5 + 0.05 * math.sin(5 * time_s)
    return normal, 0.4 * normal * math.copysign(1, math.cos(math.pi * time_s))


@pytest.mark.parametrize("rate_hz", [60, 1_000])
def test_a_finger_that_strokes_and_presses_is_plausible(rate_hz):
    assert implausible_places(sampled(stroking, rate_hz=rate_hz)) == []
    assert implausible_forces(sampled(pressing, rate_hz=rate_hz)) == []


@pytest.mark.parametrize(
    "values, said",
    [
        (
            lambda t: (65535.0 if t > 2 else stroking(t)[0], 2.0),
            "65535 mm, which is larger than any plate",
        ),
        (lambda _: (12.5, 3.4), "the same reading for 3.0 s"),
        (lambda t: (t, 2.0), "x increases in equal steps, like a time"),
        (lambda t: (100 * t, stroking(t)[0]), "a time stamp or a counter"),
        (lambda t: (280 * math.sin(25 * t), 2.0), "a median speed of"),
    ],
)
def test_a_place_that_is_no_fingers_is_told(values, said):
    assert said in "; ".join(implausible_places(sampled(values)))


@pytest.mark.parametrize(
    "values, said",
    [
        (lambda t: (0.1 * pressing(t)[1], pressing(t)[0]), "appear to be swapped"),
        (lambda t: (-pressing(t)[0], pressing(t)[1]), "check its sign and its tare"),
        (lambda t: (1000 * pressing(t)[0], pressing(t)[1]), "a force of"),
        (lambda _: (0.5, 0.2), "the same reading"),
    ],
)
def test_a_force_that_is_no_fingers_is_told(values, said):
    assert said in "; ".join(implausible_forces(sampled(values)))


def test_too_few_samples_tell_nothing():
    assert implausible_places(sampled(lambda t: (t, 2.0), duration_s=0.1)) == []


@pytest.mark.parametrize(
    "line, numbers",
    [
        ("12,5;3,4", [12.5, 3.4]),
        ("12,5\t-3,4", [12.5, -3.4]),
        ("12;3", [12, 3]),
        ("12.5,3.4", [12.5, 3.4]),
        ("12,3", [12, 3]),
        ("12, 3", [12, 3]),
    ],
)
def test_decimal_commas_are_read_where_something_else_separates(line, numbers):
    assert numbers_of(line) == numbers
