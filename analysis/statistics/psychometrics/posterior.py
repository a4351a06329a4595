"""Estimate threshold and slope from their marginal posterior distributions.

The posterior is computed on a grid of the parameters of `psychometric_fit`. The priors are:

- threshold: uniform in the curve's coordinate, from one range of the levels below the lowest level
  to one range above the highest level;
- slope: log-normal with standard deviation `SLOPE_SD`. For a logarithmic curve, the median is
  `USUAL_SLOPE`, which lies between 1.3 (d' proportional to the level) and 3.5 (contrast detection,
  Watson and Pelli 1983, Perception & Psychophysics 33, 113-120). For other curves, a curve with the
  median slope rises from 5 to 95 % over the range of levels;
- lapse rate: uniform up to its bound (Wichmann and Hill 2001, Perception & Psychophysics 63,
  1293-1313); a free guess rate is uniform up to its own bound.

Levels may depend on earlier answers, because the rule that chose the levels does not affect the
posterior. For measurements of the intervals' coverage, see
``docs/validation/measured/statistics.md``.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from slipscale.analysis.statistics.psychometrics import psychometric_fit as likelihood
from slipscale.analysis.statistics.psychometrics.psychometric_fit import Array, Counts, Model

USUAL_SLOPE = 2.0
SLOPE_SD = 0.6
#: Half-width of the grid of log slopes around the prior's median, in prior standard deviations.
SLOPE_SDS = 3.5
#: Numbers of threshold and slope values on the coarse grid, which locates the posterior, and on the
#: fine grid.
COARSE, FINE = (60, 30), (100, 40)
LAPSES, GUESSES = 8, 10
#: Probability omitted at each end of the coarse grid; it is too small to change an interval.
TAIL = 1e-5


@dataclass(frozen=True, slots=True, kw_only=True)
class Marginals:
    """The medians and interval ends of the posterior for one data set.

    Parameters
    ----------
    threshold, log_slope : array, shape (3,)
        Median, lower end and upper end. The threshold is a position on the curve's axis;
        `log_slope` is a natural logarithm.
    lapse, guess : float
        Posterior means.
    """

    threshold: Array
    log_slope: Array
    lapse: float
    guess: float


def marginals(model: Model, counts: Counts, confidence: float) -> Marginals:
    """Return the medians and equal-tailed intervals of the posterior.

    Parameters
    ----------
    counts : Counts
        Answer counts of a single data set.
    """
    bounds = likelihood.search_bounds(model, counts.u)
    low, high = bounds.low[0], bounds.high[0]
    seen = counts.u[0][counts.u[0] > likelihood.FAR_BELOW]
    usual = USUAL_SLOPE if model.curve.logarithmic else model.spread / np.ptp(seen)
    lapses = _middles(low[likelihood.LAPSE], high[likelihood.LAPSE], LAPSES)
    guesses = _middles(low[likelihood.GUESS], high[likelihood.GUESS], GUESSES)

    def posterior(thresholds: Array, log_slopes: Array) -> Array:
        """Return posterior probabilities, shape (thresholds, slopes, lapses, guesses)."""
        away = counts.u[0] - thresholds[:, None, None]
        share = model.curve.distribution(model.offset + np.exp(log_slopes)[:, None] * away)
        value = np.stack(
            [
                counts.log_likelihood(lower + (1 - lower - lapse) * share)
                for lapse, guess in product(lapses, guesses)
                for lower in [lapse if model.guess == "equal to lapse" else guess]
            ],
            axis=-1,
        ).reshape(len(thresholds), len(log_slopes), len(lapses), len(guesses))
        value -= ((log_slopes - np.log(usual))[:, None, None] / SLOPE_SD) ** 2 / 2
        weight = np.exp(value - value.max())
        return np.asarray(weight / weight.sum())

    thresholds = np.linspace(low[likelihood.THRESHOLD], high[likelihood.THRESHOLD], COARSE[0])
    log_slopes = np.log(usual) + SLOPE_SD * np.linspace(-SLOPE_SDS, SLOPE_SDS, COARSE[1])
    found = posterior(thresholds, log_slopes)
    thresholds = _where(thresholds, found.sum(axis=(1, 2, 3)), FINE[0])
    log_slopes = _where(log_slopes, found.sum(axis=(0, 2, 3)), FINE[1])
    found = posterior(thresholds, log_slopes)
    return Marginals(
        threshold=_quantiles(thresholds, found.sum(axis=(1, 2, 3)), confidence),
        log_slope=_quantiles(log_slopes, found.sum(axis=(0, 2, 3)), confidence),
        lapse=float(found.sum(axis=(0, 1, 3)) @ lapses),
        guess=float(found.sum(axis=(0, 1, 2)) @ guesses),
    )


def _middles(low: float, high: float, parts: int) -> Array:
    if low >= high:
        return np.array([low])
    return np.asarray(low + (high - low) * (np.arange(parts) + 0.5) / parts)


def _where(values: Array, weights: Array, points: int) -> Array:
    """Return a finer grid for the part of a coarse grid with non-negligible probability."""
    below = np.cumsum(weights)
    first = max(int(np.searchsorted(below, TAIL)) - 1, 0)
    last = min(int(np.searchsorted(below, 1 - TAIL)) + 1, len(values) - 1)
    return np.linspace(values[first], values[last], points)


def _quantiles(values: Array, weights: Array, confidence: float) -> Array:
    """Return the median and the interval ends of a weighted grid, by linear interpolation."""
    below = np.cumsum(weights) - weights / 2
    return np.interp([0.5, (1 - confidence) / 2, (1 + confidence) / 2], below, values)
