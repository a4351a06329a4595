"""Transients: what a plate plays from the trigger on."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipscale.faults import UserError
from slipscale.stimuli.modulation import DEFAULT_MODULATOR, Modulator
from slipscale.stimuli.transient import HELD_S, Transient


def transient(**changes):
    usual = {"from_level": 1.0, "to_level": 2.0, "transition_s": 0.01, "position_mm": 5.0}
    return Transient(**usual | changes)


@settings(deadline=None)
@given(
    transition=st.floats(0.002, 0.5),
    duration=st.none() | st.floats(0.004, 2.0),
    to_level=st.floats(0, 2.5),
)
def test_the_plates_list_is_the_stated_change_at_any_time(transition, duration, to_level):
    if duration is not None:
        duration = max(duration, transition)
    change = transient(transition_s=transition, duration_s=duration, to_level=to_level)
    played = change.change()
    DEFAULT_MODULATOR.check(played)
    assert len(played.levels) * played.step_s >= change.active_s + HELD_S * 0.99
    for number in range(40):
        time_s = number / 40 * (change.active_s + HELD_S)
        assert played.at_level(time_s) == pytest.approx(change.level_after(time_s), abs=1e-9)


@pytest.mark.parametrize("duration", [None, 0.06])
def test_a_straight_line_is_played_in_pieces_that_stay_near_it(duration):
    line = transient(shape="linear", transition_s=0.03, duration_s=duration)
    played = line.change()
    pieces = round(0.03 / played.step_s)
    assert pieces >= 5
    for number in range(200):
        time_s = number / 200 * (line.active_s + 0.1)
        # A half cosine is at most a tenth of its height off the straight line.
        assert abs(played.at_level(time_s) - line.level_after(time_s)) < 0.11 / pieces


def test_a_duration_that_equal_steps_cannot_make_is_refused_with_one_that_they_can():
    with pytest.raises(UserError, match=r"duration_s is 0\.0267.*the nearest duration is 0\.028"):
        transient(shape="linear", transition_s=0.014, duration_s=0.0267).change()


def test_plate_and_film_follow_a_change_one_after_the_other():
    followed = transient(duration_s=0.004, transition_s=0.002).followed()
    # 1 - (6 e^(-4/6) - 0.626 e^(-4/0.626)) / (6 - 0.626), both time constants in ms.
    assert followed.friction == pytest.approx(0.427, abs=1e-3)
    assert followed.plate == pytest.approx(0.998, abs=1e-3)
    assert followed.rise_s == pytest.approx(0.0133, abs=1e-4)
    assert transient().followed().friction == 1
    assert transient(to_level=1.0).followed() is None
    slow = Modulator(quality_factor=574.95, film_time_constant_s=0.0060004)
    assert transient(duration_s=0.01).followed(slow).friction == pytest.approx(0.496, abs=0.002)


@pytest.mark.parametrize(
    "changes, said",
    [
        ({"force_n": 0.5}, "expected exactly one of position_mm, force_n, delay_s"),
        ({"position_mm": None}, "expected exactly one of position_mm, force_n, delay_s"),
        ({"from_level": 0.0}, "initial is 0.0|from_level is 0.0|expected above 0"),
        ({"transition_s": 0.02, "duration_s": 0.01}, r"at least transition_s .* but is 0\.01"),
        ({"shape": "step"}, r"unknown shape 'step' \(expected one of: cosine, linear\)"),
        (
            {"transition_s": 0.001},
            r"transition_s is 0\.001, but the plate.* need 0\.002",
        ),
        ({"transition_s": 0.01, "shape": "linear"}, r"need 0\.012 or more for a linear"),
        (
            {"transition_s": 0.002, "duration_s": 0.003},
            r"duration_s is 0\.003.*need 0\.004",
        ),
    ],
)
def test_what_is_no_change_or_too_fast_is_refused(changes, said):
    with pytest.raises(UserError, match=said):
        transient(**changes).loop()
