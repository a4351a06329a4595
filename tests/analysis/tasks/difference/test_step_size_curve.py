"""The curve of "yes" against the size of the step."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.collections import PathCollection
from scipy import optimize, special, stats

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.difference import sentences as apa_difference
from slipscale.analysis.tasks.difference.step_size_curve import curve, psychometric, separated
from slipscale.analysis.tasks.difference.verbal_coding import load_codebook
from slipscale.analysis.tasks.difference.yes_no import analyse_differences, own_thresholds
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

STEPS = np.array([0.0, 0.5, 0.7, 1.1])


def answers(intercept, slope, people, repetitions=1, *, seed=1, spread=0.0):
    rng = np.random.default_rng(seed)
    removed = np.tile(STEPS, people * repetitions)
    who = np.repeat(np.arange(people), len(STEPS) * repetitions)
    own = spread * rng.standard_normal(people)[who]
    felt = rng.random(len(removed)) < special.expit(intercept + slope * removed + own)
    return pd.DataFrame(
        {
            "participant_id": who,
            "level_before": 2.3,
            "level": 2.3 - removed,
            "difference_felt": felt.astype(float),
        }
    )


def test_a_known_curve_is_recovered_within_its_interval_as_often_as_stated():
    """95 % intervals of 30 studies: binomially, 26 to 30 hold the truth (p > .99).

    Without differences between people the population's slope is the simulated one.
    """
    found = [psychometric(answers(-2, 4, 20, 3, seed=seed)) for seed in range(30)]
    held = sum(one.interval.low <= 4 <= one.interval.high for one in found)
    assert 26 <= held <= 30
    assert np.mean([one.log_odds_per_unit for one in found]) == pytest.approx(4, abs=0.4)
    assert np.mean([one.half_yes for one in found]) == pytest.approx(0.5, abs=0.04)


def test_the_interval_of_half_yes_holds_the_truth_as_often_as_stated():
    """95 % intervals of 40 studies: binomially, 35 to 40 hold the truth (p > .99)."""
    found = [psychometric(answers(-2, 4, 12, 2, seed=seed)).half_yes_interval for seed in range(40)]
    assert sum(each is not None and each.low <= 0.5 <= each.high for each in found) >= 35


def test_a_slope_that_is_not_reliably_above_0_bounds_no_threshold():
    found = psychometric(answers(-0.1, 0.1, 6, seed=3))
    assert found.p > 0.05
    assert found.half_yes_interval is None
    if found.half_yes is not None and found.half_yes > 0:
        assert "with an unbounded confidence interval" in apa_difference.psychometric(
            found, 0.95, PLATE_AMPLITUDE
        )


def test_the_ends_of_fieller_s_interval_are_as_far_from_half_yes_as_the_band_says():
    """At each end the band's other side crosses one half: the same statement twice."""
    found = psychometric(answers(-2, 4, 15, 2, seed=7))
    ends = np.array(list(found.half_yes_interval))
    _, low, high = curve(found, ends)
    assert high[0] == pytest.approx(0.5, abs=1e-6)
    assert low[1] == pytest.approx(0.5, abs=1e-6)


def test_the_weber_fraction_is_of_the_amplitude_before():
    """Of one amplitude before, it is the same curve on another scale."""
    steps = answers(-2, 4, 15, 2, seed=7)
    size, weber = psychometric(steps), psychometric(steps, measure="weber_fraction")
    assert weber.half_yes == pytest.approx(size.half_yes / 2.3, rel=1e-5)
    assert list(weber.half_yes_interval) == pytest.approx(
        [bound / 2.3 for bound in size.half_yes_interval], rel=1e-5
    )
    text = apa_difference.psychometric(weber, 0.95, PLATE_AMPLITUDE)
    assert f"at a Weber fraction of {weber.half_yes:.2f}, 95% CI [" in text


def test_a_weber_fraction_tells_apart_what_the_size_confounds():
    """Yes depends on the fraction: the same size is felt from a small amplitude only."""
    rng = np.random.default_rng(2)
    before = np.tile([1.0, 1.0, 4.0, 4.0], 100)
    after = before * np.tile([1.0, 0.6, 1.0, 0.6], 100)
    fraction = 1 - after / before
    steps = pd.DataFrame(
        {
            "participant_id": np.repeat(np.arange(20), 20),
            "level_before": before,
            "level": after,
            "difference_felt": (rng.random(400) < special.expit(-2 + 8 * fraction)).astype(float),
        }
    )
    weber = psychometric(steps, measure="weber_fraction")
    assert weber.interval.low < 8 < weber.interval.high
    assert weber.half_yes_interval.low < 0.25 < weber.half_yes_interval.high
    assert weber.t > psychometric(steps).t


def test_steps_from_nothing_have_no_weber_fraction():
    steps = answers(-2, 4, 5, seed=1).assign(level_before=0.0)
    assert "every step begins at 0" in psychometric(steps, measure="weber_fraction").reason


def test_own_thresholds_are_those_of_their_answers_and_need_enough_of_them():
    found = own_thresholds(answers(-6, 12, 4, 25, seed=11), 0.95)
    assert len(found) == 4
    for own in found.values():
        assert own.threshold_level.value == pytest.approx(0.5, abs=0.15)
        low, high = own.threshold_level.interval
        assert low < own.threshold_level.value < high
    few = own_thresholds(answers(-2, 4, 3, 2, seed=1), 0.95)
    assert all(isinstance(own, NotComputed) and "at least 20" in own.reason for own in few.values())


def test_answers_that_do_not_correlate_give_the_maximum_likelihood_curve():
    steps = answers(-1, 3, 400, seed=4)
    x = (2.3 - steps["level"]).to_numpy()
    y = steps["difference_felt"].to_numpy()

    def minus_log_likelihood(theta):
        eta = theta[0] + theta[1] * x
        return np.sum(np.logaddexp(0, eta) - y * eta)

    likeliest = optimize.minimize(minus_log_likelihood, [0.0, 1.0]).x
    found = psychometric(steps)
    assert found.intercept == pytest.approx(likeliest[0], abs=0.02)
    assert found.log_odds_per_unit == pytest.approx(likeliest[1], abs=0.05)


def test_people_who_differ_show_in_the_correlation_of_their_answers():
    assert psychometric(answers(-2, 3, 60, 3, spread=2.0)).correlation > 0.15
    assert abs(psychometric(answers(-2, 3, 60, 3)).correlation) < 0.05


@pytest.mark.parametrize(
    "removed,felt,words",
    [
        ([0, 0, 0.5, 1.1], [0, 0, 1, 1], "answers (complete separation)"),
        (
            *([0, 0.5, 0.5, 1.1], [0, 0, 1, 1]),
            "answers, except at one step size (quasi-complete separation)",
        ),
        ([0, 0.5, 0.5, 1.1], [1, 1, 1, 1], "every answer is yes"),
        ([0.5, 0.5, 0.5, 0.5], [0, 1, 0, 1], "one step size"),
    ],
)
def test_data_without_a_finite_slope_gets_the_reason(removed, felt, words):
    steps = pd.DataFrame(
        {
            "participant_id": list("abcd") * 2,
            "level_before": 2.3,
            "level": 2.3 - np.array(removed * 2),
            "difference_felt": np.array(felt * 2, float),
        }
    )
    found = psychometric(steps)
    assert words in found.reason
    assert words in apa_difference.psychometric(found, 0.95, PLATE_AMPLITUDE)


@given(st.lists(st.tuples(st.integers(0, 3), st.booleans()), min_size=1, max_size=12))
def test_separation_is_what_a_growing_slope_never_makes_less_likely(pairs):
    """A slope to infinity is at least as likely as any finite one: that is separation."""
    removed = np.array([float(x) for x, _ in pairs])
    felt = np.array([float(y) for _, y in pairs])
    a_threshold_separates = any(
        all(((x - t) * sign >= 0 if y else (x - t) * sign <= 0) for x, y in pairs)
        for t in np.arange(-0.5, 4, 0.5)
        for sign in (1, -1)
    )
    assert (separated(removed, felt) is not None) == a_threshold_separates


@pytest.mark.parametrize("size", [0.0, 0.3, 1.1])
def test_the_band_at_a_size_is_the_interval_of_the_intercept_counted_from_there(size):
    steps = answers(-2, 4, 15, 2, seed=7)
    found = psychometric(steps)
    moved = psychometric(steps.assign(level=steps["level"] + size))
    half = stats.t.ppf(0.95, found.df) * moved.covariance[0][0] ** 0.5
    share, low, high = (float(x[0]) for x in curve(found, np.array([size]), 0.9))
    assert special.logit(share) == pytest.approx(moved.intercept, rel=1e-4)
    assert special.logit(low) == pytest.approx(moved.intercept - half, rel=1e-3)
    assert special.logit(high) == pytest.approx(moved.intercept + half, rel=1e-3)


#: Area of a ring for each participant.
RING = 34.0


def drawn(steps):
    from slipscale.analysis.tasks.difference.figures import difference

    steps = steps.assign(catch=steps["level_before"] == steps["level"], verbal_report="")
    return difference(analyse_differences(steps, load_codebook()), steps)


def rings(figure):
    """The rings of the lower panel, whose areas count participants."""
    return [each for each in figure.axes[1].collections if isinstance(each, PathCollection)]


def test_the_figure_shows_the_curve_and_every_participant_once_at_every_size():
    figure = drawn(answers(-2, 4, 9, 2, seed=7))
    lines = {line.get_label(): line for line in figure.axes[1].lines}
    areas = [float(ring.get_sizes()[0]) for ring in rings(figure)]
    assert sum(areas) == pytest.approx(9 * len(STEPS) * RING)
    assert "logistic curve" in lines


def test_separated_answers_are_drawn_without_a_curve_and_one_size_without_an_axis_for_it():
    separate = answers(-2, 4, 9, seed=7).assign(difference_felt=np.tile([0.0, 1, 1, 1], 9))
    figure = drawn(separate)
    assert "logistic curve" not in [line.get_label() for line in figure.axes[1].lines]
    assert rings(figure)
    alike = separate[np.isclose(separate["level"], 2.3 - 0.7)]
    assert len(drawn(alike).axes) == 1


@pytest.mark.parametrize("unsure,between", [(1, (0.0, 0.5)), (6, None)])
def test_half_of_the_answers_are_not_placed_where_nothing_was_presented(unsure, between):
    """Of 6 people with 12 steps per size, `unsure` answers at 0 are yes, and as many at 0.5 no."""
    rows = [
        (f"p{who}", size, int((size > 0) != (size < 1 and place == 0 and who < unsure)))
        for who in range(6)
        for size in (0.0, 0.5, 1.2)
        for place in range(12 if unsure == 1 else 5)
    ]
    steps = pd.DataFrame(rows, columns=["participant_id", "size", "difference_felt"])
    steps = steps.assign(level_before=2.3, level=2.3 - steps["size"])
    found = psychometric(steps)
    assert found.half_yes_between == (pytest.approx(between) if between else None)
    text = apa_difference.psychometric(found, 0.95, PLATE_AMPLITUDE)
    assert ("half of the answers were “yes” between 0.00 and 0.50 µm" in text) is bool(between)


def test_few_observers_are_reported_one_by_one_and_no_population_is_denied():
    """Hecht, Shlaer and Pirenne (1942): each goes from almost no to nearly all; p is .209."""
    counts = {
        "SH": ((46.9, 73.1, 113.8, 177.4, 276.1, 421.7), (0, 3, 12, 26, 35, 35), 35),
        "SS": ((24.1, 37.6, 58.6, 91.0, 141.9, 221.3), (0, 2, 8, 22, 36, 40), 40),
        "MHP": ((37.6, 58.6, 91.0, 141.9, 221.3, 342.8), (3, 6, 11, 25, 32, 34), 35),
    }
    rows = [
        (who, level, float(place < yes))
        for who, (levels, yeses, n) in counts.items()
        for level, yes in zip(levels, yeses, strict=True)
        for place in range(n)
    ]
    steps = pd.DataFrame(rows, columns=["participant_id", "level_before", "difference_felt"])
    found = psychometric(steps.assign(level=0.0))
    assert found.p > 0.05
    for who, (levels, yeses, n) in counts.items():
        rate = np.array(yeses) / n
        design = np.stack([np.ones(6), levels], axis=1)

        def minus_log(b, design=design, rate=rate, n=n):
            odds = design @ b
            return -n * (rate * odds - np.logaddexp(0, odds)).sum()

        best = optimize.minimize(minus_log, [-3.0, 0.03], method="Nelder-Mead", tol=1e-12).x
        p = special.expit(design @ best)
        information = design.T @ (design * (n * p * (1 - p))[:, None])
        z = best[1] / np.sqrt(np.linalg.inv(information)[1, 1])
        assert found.own_z[who] == pytest.approx(z, rel=1e-3)
    text = apa_difference.psychometric(found, 0.95, PLATE_AMPLITUDE)
    assert "in 3 of 3 participants" in text
    assert "cannot be tested with so few participants" in text
    assert "did not depend" not in text


@pytest.mark.parametrize(
    "answers, said",
    [
        ({("p0", 0.7)}, "too few participants who answered “yes” (1; at least 3 are needed)"),
        ({("p0", 0.7), ("p1", 1.1)}, "too few participants who answered “yes” (2; at least 3"),
    ],
)
def test_a_slope_that_one_or_two_people_decide_is_not_tested(answers, said):
    """With 1 "yes" of 24 answers, the slope had t(4) = 21 and p < .001."""
    rows = [(f"p{person}", size) for person in range(6) for size in (0.0, 0.5, 0.7, 1.1)]
    for flipped in (False, True):
        steps = pd.DataFrame(
            {
                "participant_id": [who for who, _ in rows],
                "level_before": 2.0,
                "level": [2.0 - size for _, size in rows],
                "difference_felt": [float((row in answers) != flipped) for row in rows],
            }
        )
        found = psychometric(steps)
        assert isinstance(found, NotComputed)
        assert found.reason.startswith(said.replace("yes", "no") if flipped else said)
