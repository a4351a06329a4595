"""Friction maps: amplitudes from the greys of an image."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipscale.faults import UserError
from slipscale.stimuli.friction_map import MOST_PIXELS, FrictionMap, packed
from slipscale.stimuli.modulation import DEFAULT_MODULATOR

RAMP = (bytes([0, 51, 102, 153, 204, 255]),)
SQUARE = (bytes([0, 0, 0]), bytes([0, 255, 0]), bytes([51, 51, 51]))


def friction_map(rows=RAMP, **changes):
    usual = {
        "black_level": 0.5,
        "white_level": 2.0,
        "pixel_mm": 2.0,
        "pixels": packed(rows),
        "columns": len(rows[0]),
        "label": "T1",
    }
    return FrictionMap(**usual | changes)


def test_amplitudes_are_interpolated_between_the_middles_of_pixels_from_the_maps_middle():
    surface = friction_map()  # middles at -5, -3, ... 5 mm; 0.3 µm from pixel to pixel
    for place_mm, level in (
        (-9, 0.5),
        (-5, 0.5),
        (-4, 0.65),
        (0, 1.25),
        (3, 1.7),
        (5, 2.0),
        (9, 2),
    ):
        assert surface.level_at(place_mm) == pytest.approx(level)
    assert (surface.level, surface.settled_level) == pytest.approx((2.0, 1.25))
    assert surface.shown(0.5) == pytest.approx(1.25)


def test_the_top_of_the_image_is_at_positive_y():
    surface = friction_map(SQUARE)
    assert surface.level_at(0, 0) == pytest.approx(2.0)
    assert surface.level_at(0, 2) == pytest.approx(0.5)
    assert surface.level_at(0, -2) == pytest.approx(0.8)
    assert surface.level_at(0, 1) == pytest.approx(1.25)
    assert surface.needs_sensor
    assert surface.loop() is None
    assert not friction_map().needs_sensor


@settings(deadline=None)
@given(
    greys=st.binary(min_size=2, max_size=80).filter(lambda row: len(set(row)) > 1),
    speed=st.floats(1, 100),
)
def test_a_profile_is_played_within_its_range_and_what_the_plate_follows(greys, speed):
    surface = friction_map((greys,), finger_speed_mm_s=speed)
    played = surface.loop()
    DEFAULT_MODULATOR.check(played)
    assert played.period_s == pytest.approx(len(greys) * 2.0 / speed)
    assert min(played.levels) >= min(surface.level_at(-1e6), 0.5) - 1e-9
    assert max(played.levels) <= surface.level + 1e-9
    assert surface.followed().friction <= surface.followed().plate <= 1


def test_friction_follows_less_of_a_map_with_smaller_pixels():
    """A white pixel on black is a step of 40 ms, and of 2 ms: 1 - exp(-t/6 ms) of it."""
    bar = (bytes([0] * 9 + [255] + [0] * 9),)
    assert friction_map(bar).followed().friction == pytest.approx(0.9987, abs=0.002)
    fine = friction_map(bar, pixel_mm=0.1).followed()
    assert fine.friction == pytest.approx(0.28, abs=0.02)
    assert not friction_map(bar, pixel_mm=0.05).followed().felt
    assert friction_map((bytes([9, 9]),)).followed() is None


@pytest.mark.parametrize(
    "changes, said",
    [
        ({"pixels": "!"}, "the image cannot be read"),
        ({"pixels": packed((bytes(MOST_PIXELS + 1),))}, "the number of pixels or columns is wrong"),
        ({"columns": 5}, "the number of pixels or columns is wrong"),
        ({"columns": 0}, "the number of pixels or columns is wrong"),
        ({"pixel_mm": 0.0}, "pixel_mm is 0.0, expected above 0"),
        ({"white_level": -1.0}, "white is -1.0, expected 0 or more"),
        (
            {"pixel_mm": 0.05},
            "crosses the image in 6 ms, but the plate .* need 8 ms",
        ),
    ],
)
def test_what_is_no_map_or_too_fast_is_refused(changes, said):
    with pytest.raises(UserError, match=said):
        friction_map(**changes).loop()
