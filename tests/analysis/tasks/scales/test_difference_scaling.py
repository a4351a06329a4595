"""Difference scales (MLDS)."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import statsmodels.api as sm

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.scales.difference_scaling import (
    difference_scale,
    triads_as_quadruples,
)
from slipscale.faults import UserError

DATA = Path(__file__).parents[3] / "data"
TRUE = np.array([0.0, 0.1, 0.3, 0.6, 1.0])


def judged(quadruples, values, noise, rng):
    distance = np.abs(values[quadruples[:, 3]] - values[quadruples[:, 2]]) - np.abs(
        values[quadruples[:, 1]] - values[quadruples[:, 0]]
    )
    return distance + noise * rng.standard_normal(len(quadruples)) > 0


def all_quadruples(surfaces, repeats):
    pairs = list(combinations(range(surfaces), 2))
    return np.repeat([(*p, *q) for p, q in combinations(pairs, 2)], repeats, axis=0)


def test_the_published_scale_of_correlations_is_reproduced():
    """Knoblauch and Maloney 2008, J. Stat. Softw. 25(2), section 4.2 (data kk1 to kk3 of MLDS).

    The reciprocal of the largest value is 0.179; the scale is almost flat up to a correlation of
    0.3, and from 0.4 on is the correlation's square (the stimuli are 0, 0.1 ... 0.9, 0.98).
    """
    *columns, larger, trials = np.loadtxt(
        DATA / "difference_scaling_kk.csv", delimiter=",", skiprows=1, dtype=int
    ).T
    quadruples = np.repeat(np.stack(columns, axis=1), trials, axis=0)
    answers = np.concatenate([np.arange(n) < k for k, n in zip(larger, trials, strict=True)])
    found = difference_scale(quadruples, answers, simulations=20)
    assert found.answers == 990
    assert round(found.noise, 3) == 0.179
    values = np.array(found.values)
    assert np.abs(values[:4]).max() < 0.02
    correlation = np.array([0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.98])
    np.testing.assert_allclose(values[4:], correlation**2 / 0.98**2, atol=0.07)


def test_the_truth_is_recovered_within_three_standard_errors():
    rng = np.random.default_rng(3)
    quadruples = all_quadruples(5, 6)
    found = [
        difference_scale(quadruples, judged(quadruples, TRUE, 0.3, rng), simulations=1)
        for _ in range(60)
    ]
    values = np.array([one.values for one in found])[:, 1:-1]
    error = values.std(axis=0, ddof=1) / len(found) ** 0.5
    assert np.all(np.abs(values.mean(axis=0) - TRUE[1:-1]) < 3 * error)


def test_intervals_hold_the_truth_and_narrow_with_answers():
    rng = np.random.default_rng(4)
    widths = []
    for repeats in (3, 27):
        quadruples = all_quadruples(5, repeats)
        found = difference_scale(quadruples, judged(quadruples, TRUE, 0.3, rng), simulations=200)
        inner = found.intervals[1:-1]
        assert found.intervals[0] is found.intervals[-1] is None
        assert sum(one.low <= x <= one.high for one, x in zip(inner, TRUE[1:-1], strict=True)) >= 2
        low, high = found.noise_interval
        assert low < 0.3 < high
        widths.append(np.mean([one.high - one.low for one in inner]))
    assert widths[0] / widths[1] == pytest.approx(3, rel=0.25)


def test_triads_are_quadruples_that_share_their_middle():
    rng = np.random.default_rng(6)
    triads = np.repeat(list(combinations(range(5), 3)), 40, axis=0)
    quadruples = triads_as_quadruples(triads)
    assert quadruples[0].tolist() == [0, 1, 1, 2]
    found = difference_scale(quadruples, judged(quadruples, TRUE, 0.2, rng), simulations=10)
    np.testing.assert_allclose(found.values, TRUE, atol=0.08)


def test_the_order_within_a_pair_does_not_matter():
    rng = np.random.default_rng(7)
    quadruples = all_quadruples(4, 8)
    answers = judged(quadruples, TRUE[[0, 1, 3, 4]], 0.3, rng)
    turned = quadruples[:, [1, 0, 3, 2]]
    assert difference_scale(quadruples, answers, simulations=5) == difference_scale(
        turned, answers, simulations=5
    )


def test_a_seed_gives_the_same_intervals_again():
    rng = np.random.default_rng(8)
    quadruples = all_quadruples(4, 8)
    answers = judged(quadruples, TRUE[[0, 1, 3, 4]], 0.3, rng)
    one, same, other = (
        difference_scale(quadruples, answers, simulations=20, seed=seed) for seed in (1, 1, 2)
    )
    assert one == same
    assert one.intervals != other.intervals


def test_answers_without_a_scale_get_the_reason():
    quadruples = all_quadruples(4, 4)
    sure = judged(quadruples, np.array([0, 0.15, 0.4, 1.0]), 0.0, np.random.default_rng(1))
    assert "no lower limit" in difference_scale(quadruples, sure).reason
    assert "do not connect" in difference_scale([[0, 1, 2, 3]] * 9, [True, False, True] * 3).reason
    assert difference_scale([[0, 1, 0, 1]], [True]) == NotComputed(
        "too few surfaces (2; at least 3 are needed)"
    )


def test_the_scale_is_that_of_a_probit_model():
    values = np.array([0.0, 0.2, 0.5, 0.7, 1.0])
    quadruples = all_quadruples(5, 6)
    larger = judged(quadruples, values, 0.3, np.random.default_rng(4))
    found = difference_scale(quadruples, larger, simulations=40)
    design = np.zeros((len(quadruples), 5))
    for column, weight in enumerate((1, -1, -1, 1)):
        np.add.at(design, (np.arange(len(quadruples)), quadruples[:, column]), weight)
    probit = sm.families.links.Probit()
    fitted = sm.GLM(larger.astype(float), design[:, 1:], sm.families.Binomial(probit)).fit(
        tol=1e-13
    )
    assert found.noise == pytest.approx(1 / fitted.params[-1], rel=1e-6)
    assert found.values[1:] == pytest.approx(fitted.params / fitted.params[-1], rel=1e-6)


def test_too_few_answers_for_a_bootstrap_say_so():
    quadruples = all_quadruples(4, 1)
    # Two judgements against all others: a scale exists, but many simulations make no error.
    answers = judged(quadruples, np.array([0, 0.15, 0.4, 1.0]), 0.0, np.random.default_rng(1))
    answers[:2] = ~answers[:2]
    found = difference_scale(quadruples, answers, simulations=60)
    assert "no scale could be estimated from" in found.reason


@pytest.mark.parametrize(
    "quadruples,answers,words",
    [
        ([[0, 1, 2]], [True], "four surfaces"),
        ([[0, 1, 2, 3]], [True, False], "one answer per trial"),
        ([[-1, 1, 2, 3]], [True], "must be 0 or greater"),
        ([[0, 1, 2, 4]], [True], "surface 3 was never presented"),
    ],
)
def test_trials_that_cannot_be_are_refused(quadruples, answers, words):
    with pytest.raises(UserError, match=words):
        difference_scale(quadruples, answers)


def test_triads_of_other_lengths_are_refused():
    with pytest.raises(UserError, match="three surfaces per row"):
        triads_as_quadruples([[0, 1, 2, 3]])
