"""Maximise a likelihood that is integrated over differences between people.

A participant's answers are grouped by kind of trial (such as a level or a step size), and the kinds
of trials are grouped into cells (such as a condition). Some random effects, b, are shared by all
answers of a participant. A further random effect, e, is shared by a participant's answers in the
same cell:

    L(participant) = ∑_b w_b ∏_cells ∑_e w_e ∏_kinds p(b, e)^yes (1 - p(b, e))^no

All random effects have a standard normal distribution, and the integrals are sums on evenly spaced
grids. The integration error is negligible if the grid's step is smaller than the width of a
participant's likelihood. Gauss-Hermite quadrature with few points would miss a narrow peak.

Confidence intervals use the profile likelihood. At the ends of an interval, the log likelihood is
(n / 2) log(1 + t² / df) below its maximum. Here, n is the number of participants, and t is a
quantile of Student's t distribution with df degrees of freedom. For a normal sample, these limits
reproduce the t interval exactly, so intervals from few people are no narrower than the intervals of
a t test.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, log
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.statistics.arrays import Array

#: Default extent of the grids for random effects, in standard deviations from 0.
FARTHEST_NODE = 5.0
#: If the log likelihood drops by less than this before the edge of the search, there is no maximum.
FLAT = 1e-3
#: Accuracy of an interval's end, relative to its distance from the maximum, and largest number of
#: fits.
PRECISION, MOST_FITS = 1e-3, 30
#: Largest gradient at which a search is accepted (the log likelihood can then hardly grow by
#: `FLAT`), and largest number of searches. Each search starts where the previous search ended.
LARGEST_GRADIENT, MOST_SEARCHES = 0.03, 10
#: Initial distance from the maximum when searching for an interval's end, in the model's units.
FIRST_STEP = 0.3
#: Smallest initial standard deviation between people: at 0 the gradient is 0 by symmetry.
AWAY_FROM_ZERO = 0.3


class Prediction(NamedTuple):
    """Log probabilities of yes and no, shape (kinds, outer nodes, inner nodes), with derivatives.

    ``gradient`` is a function that returns the gradient of the log likelihood, given the weights of
    the yes and no answers.
    """

    log_yes: Array
    log_no: Array
    gradient: Callable[[Array, Array], Array]


class Predict(Protocol):
    """A function that predicts answers from parameters and from values of the random effects."""

    def __call__(self, theta: Array, outer: Array, inner: Array) -> Prediction:
        """Return the log probabilities of answers for all combinations of outer and inner nodes.

        Parameters
        ----------
        theta : array, shape (parameters,)
        outer : array, shape (effects, nodes, 1)
            Values of the random effects of a participant.
        inner : array, shape (nodes,)
            Values of the random effect of a cell.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class Counted:
    """Numbers of yes and no answers per person and kind of trial.

    Parameters
    ----------
    yes, no : array, shape (people, kinds)
    cells : int array, shape (kinds,)
        Index of the cell (such as a condition) to which each kind of trial belongs, from 0.
    times : array, shape (people,)
        Number of people with the counts in each row.
    """

    yes: Array
    no: Array
    cells: NDArray[np.intp]
    times: Array

    @property
    def most_answers(self) -> float:
        """Largest number of answers from one participant."""
        return float((self.yes + self.no).sum(axis=1).max())


class Maximum(NamedTuple):
    """A maximum of a likelihood: its location, the log likelihood and its gradient there."""

    theta: Array
    log_likelihood: float
    gradient: Array


class Interval(NamedTuple):
    """The estimate of a parameter (None if there is no maximum) and the ends of its interval."""

    value: float | None
    low: float
    high: float


class Grid(NamedTuple):
    """Quadrature nodes of standard normal variables, shape (effects, nodes), with log weights."""

    nodes: Array
    log_weights: Array

    def crossed(self, other: Grid) -> Grid:
        """Combine each node of this grid with each node of another grid."""
        first, second = len(self.log_weights), len(other.log_weights)
        return Grid(
            np.concatenate([np.repeat(self.nodes, second, 1), np.tile(other.nodes, (1, first))]),
            np.repeat(self.log_weights, second) + np.tile(other.log_weights, first),
        )


#: Grid with a single node at 0, for a random effect that the model omits.
NO_EFFECT = Grid(np.zeros((1, 1)), np.zeros(1))


def even(count: int, farthest: float = FARTHEST_NODE) -> Grid:
    """Return an evenly spaced grid for one standard normal variable."""
    found = np.linspace(-farthest, farthest, count)
    return Grid(found[None], -(found**2) / 2 - log(np.exp(-(found**2) / 2).sum()))


def students_fall(people: int, df: int, confidence: float) -> float:
    """Return the drop in log likelihood that defines the ends of a confidence interval."""
    from scipy import stats

    t = float(stats.t.ppf((1 + confidence) / 2, df))
    return people / 2 * log(1 + t**2 / df)


class IntegratedModel:
    """A model with random effects for people, fitted by maximum marginal likelihood.

    Parameters
    ----------
    counted : Counted
    predict : Predict
    bounds : sequence of (float, float)
        Bounds of each parameter. Equal bounds fix the parameter.
    spreads : collection of int
        Indices of parameters that are standard deviations of random effects.
    outer, inner : Grid
        Grid for a participant's random effects, and grid for the random effect of a cell.
    more : callable, optional
        Function that returns the log likelihood of additional answers without random effects, and
        its gradient.
    finer : callable, optional
        Function that returns the log likelihood on a finer grid. A higher maximum that `profiles`
        finds counts only if the finer grid confirms it: a curve that is steeper than the grid can
        pass between all answers.
    """

    def __init__(
        self,
        counted: Counted,
        predict: Predict,
        bounds: Sequence[tuple[float, float]],
        *,
        spreads: Sequence[int],
        outer: Grid,
        inner: Grid = NO_EFFECT,
        more: Callable[[Array], tuple[float, Array]] | None = None,
        finer: Callable[[Array], float] | None = None,
    ) -> None:
        self.counted, self.predict, self.bounds = counted, predict, tuple(bounds)
        self._more, self._finer = more, finer
        self.spreads = tuple(spreads)
        self.outer, self.inner = outer, inner
        self._cells = [np.flatnonzero(counted.cells == c) for c in np.unique(counted.cells)]

    def posteriors(self, theta: Array) -> tuple[Array, Array]:
        """Return each row's log likelihood and posterior probabilities of the `outer` nodes."""
        predicted = self._predicted(theta)
        logs, shares, _ = self._integrated(predicted)
        return logs, shares

    def _predicted(self, theta: Array) -> Prediction:
        return self.predict(theta, self.outer.nodes[:, :, None], self.inner.nodes[0])

    def _integrated(self, predicted: Prediction) -> tuple[Array, Array, list[Array]]:
        """Return the log likelihoods and the posterior probabilities of the grid nodes.

        The last element contains one array per cell: the probabilities of the `inner` nodes, given
        each of the `outer` nodes.
        """
        total = self.outer.log_weights
        within = []
        for kinds in self._cells:
            yes, no = self.counted.yes[:, kinds], self.counted.no[:, kinds]
            terms = np.tensordot(yes, predicted.log_yes[kinds], 1)
            terms += np.tensordot(no, predicted.log_no[kinds], 1)
            logs, share = _log_sum(terms + self.inner.log_weights)
            within.append(share)
            total = total + logs
        logs, shares = _log_sum(total)
        return logs, shares, within

    def minus_log(self, theta: Array) -> tuple[float, Array]:
        """Return the negative log likelihood and its gradient."""
        predicted = self._predicted(theta)
        logs, shares, within = self._integrated(predicted)
        weights = shares * self.counted.times[:, None]
        pull_yes, pull_no = np.empty_like(predicted.log_yes), np.empty_like(predicted.log_no)
        for kinds, share in zip(self._cells, within, strict=True):
            here = weights[:, :, None] * share
            pull_yes[kinds] = np.tensordot(self.counted.yes[:, kinds].T, here, 1)
            pull_no[kinds] = np.tensordot(self.counted.no[:, kinds].T, here, 1)
        value, gradient = float(self.counted.times @ logs), predicted.gradient(pull_yes, pull_no)
        if self._more is not None:
            own, slope = self._more(theta)
            value, gradient = value + own, gradient + slope
        return -value, -gradient

    def fit(self, start: Array, held: Mapping[int, float] | None = None) -> Maximum:
        """Return the maximum of the likelihood, optionally with some parameters fixed.

        The search is repeated until no free parameter has a large gradient, because a search with a
        lapse rate near 0 can end after a few tiny steps, far from the maximum.
        """
        from scipy import optimize

        bounds, start = list(self.bounds), np.array(start, float)
        for place in self.spreads:
            start[place] = max(start[place], min(AWAY_FROM_ZERO, bounds[place][1]))
        for place, value in (held or {}).items():
            bounds[place] = (value, value)
        low, high = np.transpose(bounds)
        start = np.clip(start, low, high)
        if np.array_equal(low, high):  # nothing to search
            value, gradient = self.minus_log(start)
            return Maximum(start, -value, -gradient)
        for _ in range(MOST_SEARCHES):
            found = optimize.minimize(
                self.minus_log, start, jac=True, method="L-BFGS-B", bounds=bounds
            )
            start = found.x
            # A parameter at a bound is free only if moving it inwards increases the likelihood.
            free = np.where(found.jac > 0, start > low, start < high)
            if np.abs(found.jac[free]).max(initial=0.0) < LARGEST_GRADIENT:
                break
        return Maximum(np.asarray(found.x), -float(found.fun), -np.asarray(found.jac))

    def higher(self, theta: Array, other: Array) -> bool:
        """Return whether the first likelihood is above the other, on the finer grid if any."""
        return self._finer is None or self._finer(theta) > self._finer(other) + FLAT

    def profiles(
        self, best: Maximum, places: Sequence[int], fall: float
    ) -> tuple[Maximum, tuple[Interval, ...]]:
        """Return parameters' estimates with the ends of their intervals, and their maximum.

        The maximum is ``best``, or a higher one that was found on the way. All intervals belong to
        the maximum that is returned.

        Parameters
        ----------
        best : Maximum
            Maximum of the likelihood if no parameter is fixed, as returned by `fit`.
        places : sequence of int
            Indices of the parameters.
        fall : float
            Drop in log likelihood at the ends of the intervals (see `students_fall`).
        """
        found = []
        for place in places:
            ends: list[float] = []
            flat = False
            for edge in self.bounds[place]:
                end, likeliest, level = self._end(best, place, edge, fall)
                if likeliest.log_likelihood > best.log_likelihood + FLAT:
                    # With this parameter fixed, a search can find a higher maximum than with all
                    # parameters free. A new search with all parameters free may even return to the
                    # lower maximum.
                    freed = self.fit(likeliest.theta)
                    higher = max(likeliest, freed, key=lambda each: each.log_likelihood)
                    if self.higher(higher.theta, best.theta):
                        return self.profiles(higher, places, fall)
                    level = False
                ends.append(end)
                flat = flat or level
            found.append(Interval(None if flat else float(best.theta[place]), *ends))
        return best, tuple(found)

    def _end(
        self, best: Maximum, place: int, edge: float, fall: float
    ) -> tuple[float, Maximum, bool]:
        """Search outwards for the point where the profile log likelihood has fallen by ``fall``.

        The square root of the drop in log likelihood is nearly linear in the parameter, so a few
        Newton steps are enough.

        Returns
        -------
        end : float
            End of the interval. Infinite if the profile log likelihood drops by less than ``fall``
            up to ``edge``, the parameter's bound.
        likeliest : Maximum
            Best fit found during the search.
        flat : bool
            Whether the profile likelihood is flat between its maximum and ``edge``.
        """
        root, inside, outside = (2 * fall) ** 0.5, float(best.theta[place]), edge
        reached, likeliest, start = False, best, best
        at = inside + float(np.clip(edge - inside, -FIRST_STEP, FIRST_STEP))
        for _ in range(MOST_FITS):
            found = self.fit(start.theta, {place: at})
            likeliest = max(likeliest, found, key=lambda each: each.log_likelihood)
            fallen = best.log_likelihood - found.log_likelihood
            value = (2 * max(fallen, 0.0)) ** 0.5
            if value < root and at == edge:
                end = -inf if edge == self.bounds[place][0] else inf
                return end, likeliest, fallen < FLAT
            inside, outside = (at, outside) if value < root else (inside, at)
            reached, start = reached or value >= root, found
            slope = -float(found.gradient[place]) / value if value > 0 else 0.0
            newton = at + (root - value) / slope if slope else inf
            within = min(inside, outside) < newton < max(inside, outside)
            step = newton if within else (inside + outside) / 2 if reached else edge
            if abs(step - at) < PRECISION * abs(at - best.theta[place]) + 1e-9:
                return float(step), likeliest, False
            at = step
        return float(at), likeliest, False


def _log_sum(terms: Array) -> tuple[Array, Array]:
    """Return the log of the sum of exponentials over the last axis, and each term's share."""
    if terms.shape[-1] == 1:
        return terms[..., 0], np.ones_like(terms)
    top = terms.max(axis=-1, keepdims=True)
    share = np.exp(terms - top)
    total = share.sum(axis=-1, keepdims=True)
    return (top + np.log(total))[..., 0], share / total
