"""Staircases and weighted up-down: where they go, and where they settle."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.experiments.protocol_parts.adaptive.curves import CURVES
from slipscale.experiments.protocol_parts.adaptive.staircase import STEP_RATIOS, staircase
from slipscale.experiments.protocol_parts.adaptive.up_down import UpDown
from slipscale.experiments.protocol_parts.adaptive.weighted import weighted
from slipscale.faults import UserError

BOUNDS = {"lowest_level": 1e-3, "highest_level": 2.3}
ANSWERS = st.lists(st.booleans(), max_size=60)


def run(rule, answers):
    tracks = [rule.start()]
    for correct in answers:
        tracks.append(tracks[-1].answered(correct=correct))
    return tracks


def answers(text):
    return [sign == "+" for sign in text]


def test_two_correct_go_down_one_error_goes_up_and_turns_are_noted():
    rule = UpDown(
        start_level=1.0,
        lowest_level=0,
        highest_level=3,
        steps_up=(0.4, 0.2),
        down_to_up=0.5,
        down_after=2,
        scale="linear",
    )
    tracks = run(rule, answers("+++-++++-"))
    levels = [track.level for track in tracks]
    # 0.2 down, up by 0.2 after the first turn, then 0.1 down twice, then up.
    assert levels == [1.0, 1.0, 0.8, 0.8, 1.0, 1.0, 0.9, 0.9, 0.8, 1.0]
    assert tracks[-1].reversal_levels == (0.8, 1.0, 0.8)


def test_an_error_breaks_the_row_of_correct_answers():
    rule = staircase(start_level=1, steps_up=(0.1,), down_after=3, **BOUNDS)
    levels = [track.level for track in run(rule, answers("++-++"))]
    assert levels[-1] == levels[3] == pytest.approx(10**0.1)


@pytest.mark.parametrize(
    "down_after,proportion", [(1, 0.7785), (2, 0.8035), (3, 0.8315), (4, 0.8584)]
)
def test_ratios_settle_where_garcia_perez_published(down_after, proportion):
    """Vision Res. 38, 1861-1881, abstract."""
    rule = staircase(start_level=1, steps_up=(0.1,), down_after=down_after, **BOUNDS)
    assert round(rule.target, 4) == proportion


@pytest.mark.parametrize("down_after,proportion", [(1, 0.5), (2, 0.707), (3, 0.794), (4, 0.841)])
def test_equal_steps_balance_at_levitts_proportions(down_after, proportion):
    """Levitt 1971, J. Acoust. Soc. Am. 49, Table I."""
    rule = UpDown(start_level=1, steps_up=(0.1,), down_after=down_after, down_to_up=1.0, **BOUNDS)
    assert round(rule.target, 3) == proportion


@given(st.floats(0.01, 0.99))
def test_weighted_steps_balance_at_the_target(target):
    rule = weighted(start_level=1, steps_up=(0.01,), target=target, **BOUNDS)
    assert rule.target == pytest.approx(target)


@given(ANSWERS, st.sampled_from(sorted(STEP_RATIOS)))
def test_the_level_is_the_sum_of_its_steps(given_answers, down_after):
    rule = staircase(
        start_level=1,
        lowest_level=1e-9,
        highest_level=1e9,
        steps_up=(0.1,),
        down_after=down_after,
    )
    down = row = 0
    for correct in given_answers:
        row = row + 1 if correct else 0
        if row == down_after:
            down, row = down + 1, 0
    up = given_answers.count(False)
    expected = 10 ** (0.1 * (up - rule.down_to_up * down))
    # Each level is rounded at the ninth decimal.
    assert run(rule, given_answers)[-1].level == pytest.approx(expected, abs=1e-5, rel=1e-5)


@given(ANSWERS)
def test_levels_stay_within_their_bounds_and_at_nine_decimals(given_answers):
    rule = weighted(start_level=1, steps_up=(0.7,), **BOUNDS)
    for track in run(rule, given_answers):
        assert 1e-3 <= track.level <= 2.3
        assert track.level == round(track.level, 9)


@given(ANSWERS, ANSWERS)
def test_a_run_resumed_from_its_answers_goes_on_the_same(before, after):
    rule = staircase(start_level=1, steps_up=(0.3, 0.1), **BOUNDS)
    halfway = run(rule, before)[-1]
    on = halfway
    for correct in after:
        on = on.answered(correct=correct)
    assert on == run(rule, before + after)[-1]


def observed(track, trials, rng):
    """Answer as an observer with a Weibull function of threshold 0.2 µm would."""
    for drawn in rng.random(trials):
        share = CURVES["weibull"].proportion(track.level, threshold_level=0.2, slope=2.0, guess=0.5)
        correct = bool(drawn < share)
        track = track.answered(correct=correct)
        yield track, correct


@pytest.mark.parametrize("down_after", STEP_RATIOS)
def test_a_long_staircase_settles_at_its_target(down_after):
    """Mean of reversals over 40 tracks of 600 trials, within 3 standard errors and 0.005 decades.

    The allowance is the bias that finite steps leave; the seed is fixed, so nothing fails by
    chance.
    """
    rule = staircase(start_level=0.5, steps_up=(0.1,), down_after=down_after, **BOUNDS)
    rng = np.random.default_rng(15)
    at_target = np.log(0.2) + CURVES["weibull"].inverse(np.array((rule.target - 0.5) / 0.5)) / 2
    found = []
    for _ in range(40):
        *_, (track, _) = observed(rule.start(), 600, rng)
        reversals = track.reversal_levels[8:]
        found.append(np.log10(reversals[len(reversals) % 2 :]).mean())
    error = np.std(found, ddof=1) / math.sqrt(40)
    assert abs(np.mean(found) - at_target / math.log(10)) < 3 * error + 0.005


@pytest.mark.parametrize("target", [0.7, 0.75, 0.85])
def test_a_long_weighted_track_is_answered_correctly_as_often_as_its_target(target):
    """What goes up comes down: with n trials the proportion is exact to a few steps over n."""
    rule = weighted(start_level=0.5, steps_up=(0.1,), target=target, **BOUNDS)
    rng = np.random.default_rng(16)
    correct = [answer for _, answer in observed(rule.start(), 4000, rng)]
    assert np.mean(correct) == pytest.approx(target, abs=10 / 4000)


def test_psychopys_staircase_takes_the_same_levels():
    """An independent implementation, trial for trial, with steps of one size."""
    from psychopy.data import StairHandler

    rng = np.random.default_rng(7)
    for down_after in (1, 2, 3):
        theirs = StairHandler(
            1.0,
            stepSizes=[0.1],
            nTrials=80,
            nReversals=1,
            nUp=1,
            nDown=down_after,
            stepType="log",
            applyInitialRule=False,
            minVal=1e-3,
            maxVal=2.3,
        )
        track = UpDown(
            start_level=1, steps_up=(0.1,), down_to_up=1.0, down_after=down_after, **BOUNDS
        ).start()
        for level in theirs:
            assert track.level == pytest.approx(level, abs=1e-7)
            correct = bool(rng.random() < 0.75)
            theirs.addResponse(int(correct))
            track = track.answered(correct=correct)
        assert track.trials >= 80


@pytest.mark.parametrize(
    "change,words",
    [
        ({"start_level": 3.0}, "the first level is 3, expected 0.001 to 2.3"),
        ({"start_level": math.nan}, "the first level is nan"),
        ({"lowest_level": 0.0}, "the lowest level is 0, expected 1e-09 or more on the log10 scale"),
        ({"highest_level": 1e-4}, "expected above the lowest"),
        ({"steps_up": ()}, "at least one step size"),
        ({"steps_up": (0.1, -0.1)}, "steps_up is -0.1"),
        ({"steps_up": (5.0,)}, "larger than the whole range of levels"),
        ({"down_after": 5}, "down_after is 5, expected one of 1, 2, 3, 4"),
    ],
)
def test_a_staircase_that_cannot_work_is_refused(change, words):
    options = {"start_level": 1.0, "steps_up": (0.1,), **BOUNDS} | change
    with pytest.raises(UserError, match=words):
        staircase(**options)


@pytest.mark.parametrize("target", [0.0, 1.0, math.nan])
def test_a_target_that_no_steps_balance_at_is_refused(target):
    with pytest.raises(UserError, match="target is"):
        weighted(start_level=1, steps_up=(0.1,), target=target, **BOUNDS)


def test_rules_of_no_row_or_no_step_down_are_refused():
    with pytest.raises(UserError, match="down_after is 0"):
        UpDown(start_level=1, steps_up=(0.1,), down_to_up=1.0, down_after=0, **BOUNDS)
    with pytest.raises(UserError, match="down_to_up is 0"):
        UpDown(start_level=1, steps_up=(0.1,), down_to_up=0.0, **BOUNDS)
