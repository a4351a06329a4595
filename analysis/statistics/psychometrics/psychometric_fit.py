"""Fit psychometric functions by maximum likelihood, for many data sets at once.

The search uses Fisher scoring with Levenberg damping and keeps each parameter within its bounds.
All data sets are updated together, so intervals, Monte Carlo tests and simulations take little more
time than one fit. To fit a single participant, use `thresholds`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from slipscale.experiments.protocol_parts.adaptive.curves import Curve

Array = npt.NDArray[np.float64]
Guess = Literal["fixed", "free", "equal to lapse"]

#: Columns of a parameter array. The threshold is a position on the curve's axis.
THRESHOLD, LOG_SLOPE, LAPSE, GUESS = range(4)
#: Probabilities are kept this far from 0 and 1, so that logarithms are finite.
EDGE = 1e-9
#: Coordinate that represents level 0 on a logarithmic axis, where every curve is at its asymptote.
FAR_BELOW = -1e6
#: Upper bound of a free guess rate.
LARGEST_GUESS = 0.5
ITERATIONS = 200
#: Gains in log likelihood below this value are ignored.
TOLERANCE = 1e-9
#: Damping at which the search stops, because shorter steps would not improve the fit.
MOST_DAMPING = 1e10
#: Number of grid values and number of grid refinements in the search for a confidence limit. The
#: resolution is 1/65,000 of the range.
SECTIONS, ROUNDS = 16, 4


@dataclass(frozen=True, slots=True)
class Counts:
    """Answer counts of several data sets.

    Parameters
    ----------
    u : array, shape (sets, levels)
        Positions of the levels on the curve's axis, as computed by `coordinates`.
    correct, trials : array, shape (sets, levels)
        Number of correct answers and number of all answers. Levels without answers are ignored.
    """

    u: Array
    correct: Array
    trials: Array

    def __getitem__(self, sets: npt.NDArray[np.intp]) -> Counts:
        """Return the selected data sets."""
        return Counts(self.u[sets], self.correct[sets], self.trials[sets])

    def log_likelihood(self, proportion: Array) -> Array:
        """Return the log likelihood of each data set, without binomial coefficients."""
        p = np.clip(proportion, EDGE, 1 - EDGE)
        wrong = self.trials - self.correct
        return np.asarray((self.correct * np.log(p) + wrong * np.log1p(-p)).sum(axis=-1))


@dataclass(frozen=True, slots=True)
class Bounds:
    """The lower and upper bounds of the parameters, each of shape (sets, 4)."""

    low: Array
    high: Array

    def __getitem__(self, sets: npt.NDArray[np.intp]) -> Bounds:
        """Return the bounds for the selected data sets."""
        return Bounds(self.low[sets], self.high[sets])


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """The psychometric model that is fitted to answers.

    Parameters
    ----------
    curve : Curve
        The family of curves.
    share : float
        Value of the curve at the threshold, without guesses and lapses.
    guess : {"fixed", "free", "equal to lapse"}
        Whether the lower asymptote is fixed, estimated or equal to the lapse rate.
    guess_rate : float
        Value of the lower asymptote, if it is fixed.
    largest_lapse : float
        Upper bound of the lapse rate. If 0, the rate is fixed at 0.
    """

    curve: Curve
    share: float = 0.5
    guess: Guess = "fixed"
    guess_rate: float = 0.5
    largest_lapse: float = 0.06

    @property
    def offset(self) -> float:
        """Argument at which `curve.distribution` has the value `share`, as at the threshold."""
        return float(self.curve.inverse(np.array(self.share)))

    @property
    def spread(self) -> float:
        """Difference between the arguments at which the curve reaches 5 % and 95 %."""
        low, high = self.curve.inverse(np.array([0.05, 0.95]))
        return float(high - low)

    def proportion(self, theta: Array, u: Array) -> Array:
        """Return the proportion correct, shape (sets, levels). For ``theta``, see `Fits`."""
        return self._with_share(theta, u)[0]

    def _with_share(self, theta: Array, u: Array) -> tuple[Array, Array, Array]:
        z = self.offset + np.exp(theta[:, [LOG_SLOPE]]) * (u - theta[:, [THRESHOLD]])
        share = self.curve.distribution(z)
        guess = theta[:, [LAPSE if self.guess == "equal to lapse" else GUESS]]
        return guess + (1 - guess - theta[:, [LAPSE]]) * share, share, z

    def with_gradient(self, theta: Array, u: Array) -> tuple[Array, Array]:
        """Return proportions, shape (sets, levels), and gradients, shape (sets, levels, 4)."""
        proportion, share, z = self._with_share(theta, u)
        equal = self.guess == "equal to lapse"
        guess = theta[:, [LAPSE if equal else GUESS]]
        rise = (1 - guess - theta[:, [LAPSE]]) * self.curve.density(z)
        gradient = np.stack(
            [
                -np.exp(theta[:, [LOG_SLOPE]]) * rise,
                (z - self.offset) * rise,
                1 - 2 * share if equal else -share,
                np.zeros_like(share) if equal else 1 - share,
            ],
            axis=2,
        )
        return proportion, gradient


@dataclass(frozen=True, slots=True, kw_only=True)
class Fits:
    """The maximum-likelihood parameters of several data sets.

    Parameters
    ----------
    theta : array, shape (sets, 4)
        Parameters in the columns `THRESHOLD`, `LOG_SLOPE`, `LAPSE` and `GUESS`.
    log_likelihood : array, shape (sets,)
        Log likelihood of each data set, without the binomial coefficients.
    bounds : Bounds
        Search ranges.
    """

    theta: Array
    log_likelihood: Array
    bounds: Bounds

    def at_bound(self, parameter: int) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
        """Return two masks, shape (sets,): parameter at its lower bound, and at its upper bound."""
        value = self.theta[:, parameter]
        low, high = self.bounds.low[:, parameter], self.bounds.high[:, parameter]
        near = 1e-6 * (high - low)
        return np.asarray(value <= low + near), np.asarray(value >= high - near)


def coordinates(curve: Curve, levels: Array) -> Array:
    """Return the positions of levels on the curve's axis.

    All positions are finite. On a logarithmic axis, a level of 0 becomes `FAR_BELOW`.
    """
    return np.maximum(curve.coordinate(levels), FAR_BELOW)


def search_bounds(model: Model, u: Array) -> Bounds:
    """Return the search range of each parameter.

    The threshold may lie outside the range of the levels, by up to the width of this range. The
    shallowest curve rises from 5 % to 95 % over twenty times the width of the range. The steepest
    curve rises from 5 % to 95 % over one tenth of the smallest distance between two levels.
    """
    seen = np.where(u > FAR_BELOW, u, np.nan)
    bottom, top = np.nanmin(seen, axis=1), np.nanmax(seen, axis=1)
    span = np.maximum(top - bottom, EDGE)
    steps = np.diff(np.sort(seen, axis=1), axis=1)
    closest = np.nanmin(
        np.where(steps > span[:, None] / 200, steps, np.inf), axis=1, initial=np.inf
    )
    closest = np.minimum(closest, span)
    zeros, ones = np.zeros(len(u)), np.ones(len(u))
    free = model.guess == "free"
    low = [bottom - span, np.log(model.spread / (20 * span)), zeros, zeros]
    high = [
        top + span,
        np.log(10 * model.spread / closest),
        model.largest_lapse * ones,
        LARGEST_GUESS * ones,
    ]
    if not free:
        rate = 0.0 if model.guess == "equal to lapse" else model.guess_rate
        low[GUESS] = high[GUESS] = rate * ones
    return Bounds(np.stack(low, axis=1), np.stack(high, axis=1))


def fit(model: Model, counts: Counts, bounds: Bounds | None = None) -> Fits:
    """Return the maximum-likelihood parameters of each data set.

    Parameters
    ----------
    bounds : Bounds or None
        Lower and upper bound of each parameter. Equal bounds fix a parameter. Default:
        `search_bounds`.
    """
    bounds = search_bounds(model, counts.u) if bounds is None else bounds
    # The likelihood can have two peaks: one at which lapses explain the errors at high levels, and
    # one at which they do not. The search therefore starts from two points.
    lapses = (0.0, model.largest_lapse)
    start = np.concatenate([_start(model, counts, bounds, lapse) for lapse in lapses])
    twice = np.tile(np.arange(len(counts.u)), 2)
    found = _climb(model, counts[twice], start, bounds[twice])
    one, other = np.split(found.log_likelihood, 2)
    better = other > one
    return Fits(
        theta=np.where(better[:, None], *np.split(found.theta, 2)[::-1]),
        log_likelihood=np.where(better, other, one),
        bounds=bounds,
    )


def profile(
    model: Model, counts: Counts, fits: Fits, parameter: int, *, drop: float
) -> tuple[Array, Array]:
    """Return the points where the profile log likelihood is ``drop`` below its maximum.

    Parameters
    ----------
    parameter : int
        `THRESHOLD` or `LOG_SLOPE`.
    drop : float
        Drop in log likelihood between the maximum and an end of the interval. For a confidence
        interval, this drop is half a chi-square quantile.

    Returns
    -------
    tuple of arrays, each of shape (sets,)
        Lower and upper ends of the interval. An end is infinite if the log likelihood does not fall
        by ``drop`` within the bounds of the parameter.
    """
    # Each set occurs twice: once for the lower end, once for the upper end.
    sets = np.tile(np.arange(len(fits.theta)), 2)
    rows = np.arange(len(sets))

    def fallen(values: Array) -> npt.NDArray[np.bool_]:
        which = np.repeat(sets, values.shape[1])
        bounds = fits.bounds[which]
        bounds.low[:, parameter] = bounds.high[:, parameter] = values.ravel()
        refitted = fit(model, counts[which], bounds)
        fall = fits.log_likelihood[which] - refitted.log_likelihood
        return np.asarray(fall > drop).reshape(values.shape)

    part = np.arange(1, SECTIONS + 1) / SECTIONS
    inside = fits.theta[sets, parameter]
    outside = np.concatenate([fits.bounds.low, fits.bounds.high])[:, parameter]
    closed = np.zeros(len(sets), dtype=bool)
    for _ in range(ROUNDS):
        values = inside[:, None] + (outside - inside)[:, None] * part
        beyond = fallen(values)
        closed |= beyond.any(axis=1)
        first = np.where(beyond.any(axis=1), beyond.argmax(axis=1), SECTIONS - 1)
        outside = values[rows, first]
        inside = np.where(first > 0, values[rows, first - 1], inside)
    never = np.repeat([-np.inf, np.inf], len(fits.theta))
    low, high = np.split(np.where(closed, (inside + outside) / 2, never), 2)
    return low, high


def _start(model: Model, counts: Counts, bounds: Bounds, lapse: float) -> Array:
    """Return the most likely parameters on a coarse grid, with shape (sets, 4).

    The grid starts with shallow curves. If a curve gives an observed answer a probability of 0, the
    gradient of its likelihood does not lead to a better curve.
    """
    sets = len(counts.u)
    # Data sets simulated from one model have the same levels and bounds, so the curves are computed
    # once.
    alike = all(np.all(each == each[:1]) for each in (counts.u, bounds.low, bounds.high))
    u, bounds = (counts.u[:1], bounds[np.arange(1)]) if alike else (counts.u, bounds)
    seen = np.where(u > FAR_BELOW, u, np.nan)
    bottom, span = np.nanmin(seen, axis=1), np.nanmax(seen, axis=1) - np.nanmin(seen, axis=1)
    threshold_held, slope_held = np.all(bounds.low >= bounds.high, axis=0)[[THRESHOLD, LOG_SLOPE]]
    best, best_value = np.empty((sets, 4)), np.full(sets, -np.inf)
    guess = (bounds.low + bounds.high)[:, GUESS] / 2
    for place in [0.0] if threshold_held else np.linspace(-0.1, 1.1, 13):
        for width in [1.0] if slope_held else (8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.1):
            theta = np.stack(
                [
                    bottom + span * place,
                    np.log(model.spread / (width * span)),
                    np.full(len(u), lapse),
                    guess,
                ],
                axis=1,
            )
            theta = np.clip(theta, bounds.low, bounds.high)
            value = counts.log_likelihood(model.proportion(theta, u))
            better = value > best_value
            best[better] = np.broadcast_to(theta, best.shape)[better]
            best_value[better] = value[better]
    return best


def _climb(model: Model, counts: Counts, start: Array, bounds: Bounds) -> Fits:
    """Climb from the starting points to local maxima of the likelihoods."""
    theta = start.copy()
    value = counts.log_likelihood(model.proportion(theta, counts.u))
    damping = np.full(len(theta), 1e-2)
    going = np.arange(len(theta))
    for _ in range(ITERATIONS):
        if not len(going):
            break
        here, some, limits = theta[going], counts[going], bounds[going]
        step = _step(model, some, here, limits, damping[going])
        proposed = np.clip(here + step, limits.low, limits.high)
        found = some.log_likelihood(model.proportion(proposed, some.u))
        gain = found - value[going]
        better = gain > 0
        moved = going[better]
        theta[moved], value[moved] = proposed[better], found[better]
        damping[going] = np.where(better, np.maximum(damping[going] / 4, 1e-12), damping[going] * 8)
        over = np.where(better, gain < TOLERANCE, damping[going] > MOST_DAMPING)
        going = going[~over]
    return Fits(theta=theta, log_likelihood=value, bounds=bounds)


def _step(model: Model, counts: Counts, theta: Array, bounds: Bounds, damping: Array) -> Array:
    p, gradient = model.with_gradient(theta, counts.u)
    p = np.clip(p, EDGE, 1 - EDGE)
    weight = 1 / (p * (1 - p))
    score = np.einsum("sk,skp->sp", (counts.correct - counts.trials * p) * weight, gradient)
    information = (gradient * (counts.trials * weight)[:, :, None]).swapaxes(1, 2) @ gradient
    low, high = bounds.low, bounds.high
    held = (low >= high) | ((theta <= low) & (score < 0)) | ((theta >= high) & (score > 0))
    score = np.where(held, 0.0, score)
    information = np.where(held[:, :, None] | held[:, None, :], 0.0, information)
    diagonal = np.einsum("spp->sp", information)
    # A parameter that is held fixed or not determined by the data has a row of zeros; a 1 on the
    # diagonal keeps the system solvable.
    ridge = np.where(diagonal > 0, damping[:, None] * diagonal, 1.0) + EDGE
    information[:, range(4), range(4)] += ridge
    return np.asarray(np.linalg.solve(information, score[:, :, None])[:, :, 0])
