"""Thresholds by a posterior: what it says, and that it is what its priors and the answers give."""

import numpy as np
import pytest

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.posterior import SLOPE_SD, USUAL_SLOPE
from slipscale.analysis.statistics.psychometrics.psychometric_function import Answers
from slipscale.analysis.statistics.psychometrics.thresholds import (
    LARGEST_LAPSE,
    fit_threshold,
    fit_threshold_by_posterior,
)
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES

LEVELS = np.array([0.05, 0.1, 0.2, 0.4, 0.8])


def answers(correct, trials, levels=LEVELS):
    return Answers(
        levels=np.asarray(levels, float),
        correct=np.asarray(correct, float),
        trials=np.full(len(levels), float(trials)),
    )


FEW = answers([6, 7, 8, 11, 12], 12)


def by_weighting(data, guess):
    """Return quantiles of threshold and slope: draws from the prior, weighted by likelihood."""
    rng = np.random.default_rng(1)
    draws = 400_000
    u = np.log(data.levels)
    span = u[-1] - u[0]
    threshold = rng.uniform(u[0] - span, u[-1] + span, draws)
    slope = np.log(USUAL_SLOPE) + SLOPE_SD * rng.standard_normal(draws)
    lapse = rng.uniform(0, LARGEST_LAPSE, draws)
    z = np.log(np.log(2)) + np.exp(slope)[:, None] * (u - threshold[:, None])
    share = -np.expm1(-np.exp(np.minimum(z, 50)))
    p = guess + (1 - guess - lapse[:, None]) * share
    log = (data.correct * np.log(p) + (data.trials - data.correct) * np.log1p(-p)).sum(axis=1)
    weight = np.exp(log - log.max())

    def quantiles(values):
        order = np.argsort(values)
        below = np.cumsum(weight[order]) / weight.sum()
        return np.interp([0.5, 0.025, 0.975], below, values[order])

    return quantiles(threshold), quantiles(slope), float((weight * lapse).sum() / weight.sum())


@pytest.mark.parametrize("method,guess", [("two_interval", 1 / 2), ("three_interval", 1 / 3)])
def test_it_is_the_prior_weighted_by_the_likelihood(method, guess):
    found = fit_threshold_by_posterior(FEW, method=method)
    threshold, slope, lapse = by_weighting(FEW, guess)
    at = found.threshold_level
    assert np.log([at.value, *at.interval]) == pytest.approx(threshold, abs=0.03)
    assert np.log([found.slope.value, *found.slope.interval]) == pytest.approx(slope, abs=0.03)
    assert found.lapse == pytest.approx(lapse, abs=0.001)


@pytest.mark.parametrize("method,curve", [("two_interval", "weibull"), ("comparison", "normal")])
def test_with_many_answers_it_is_the_likeliest_curve(method, curve):
    rng = np.random.default_rng(2)
    guess = {"two_interval": 0.5, "comparison": 0.02}[method]
    truth = {"threshold_level": 0.3, "slope": 3.0, "guess": guess, "lapse": 0.02}
    levels = np.linspace(0.05, 0.8, 9)
    data = answers(rng.binomial(3000, CURVES[curve].proportion(levels, **truth)), 3000, levels)
    posterior = fit_threshold_by_posterior(data, method=method, curve=curve)
    likeliest = fit_threshold(data, method=method, curve=curve)
    assert posterior.threshold_level.value == pytest.approx(
        likeliest.threshold_level.value, rel=0.01
    )
    assert posterior.threshold_level.interval.low == pytest.approx(
        likeliest.threshold_level.interval.low, rel=0.02
    )
    assert posterior.slope.value == pytest.approx(likeliest.slope.value, rel=0.02)


def test_a_jump_between_two_levels_leaves_the_slope_an_interval():
    data = answers([10, 10, 20, 20], 20, [0.1, 0.2, 0.4, 0.8])
    assert isinstance(fit_threshold(data).slope, NotComputed)
    found = fit_threshold_by_posterior(data)
    low, high = found.slope.interval
    assert 1 < low < found.slope.value < high < 20
    assert 0.1 < found.threshold_level.interval.low < 0.2
    assert found.threshold_level.interval.high < 0.4


def test_answers_that_do_not_rise_have_no_threshold_here_either():
    falling = answers([20, 15, 12, 9, 9], 20)
    assert fit_threshold_by_posterior(falling) == fit_threshold(falling)
