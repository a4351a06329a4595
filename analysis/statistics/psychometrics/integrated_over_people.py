"""Integrate the likelihood of counts over differences between people, and compute profiles.

A participant's answers are grouped into kinds (such as a level or a step size), and kinds into
cells (such as a condition). All kinds of a participant share random effects; the kinds in a cell
share a further one:

    L(participant) = ∑_b w_b ∏_cells ∑_e w_e ∏_kinds p(b, e)^yes (1 - p(b, e))^no

All random effects are standard normal and are summed on evenly spaced grids. If the step is
smaller than the width of a participant's likelihood, the error is negligible, whereas
Gauss-Hermite quadrature with few points misses a narrow peak.

Confidence intervals use the profile likelihood. The drop in log likelihood at their ends is (n /
2) log(1 + t² / df), which reproduces the t interval exactly for a normal sample. With few people,
intervals are therefore no narrower than those of a t test.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, log
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

#: Grids for random effects extend this many standard deviations from 0 by default.
FARTHEST_NODE = 5.0
#: If the log likelihood falls by less than this up to the edge of the search, it has no maximum.
FLAT = 1e-3
#: Relative accuracy of an interval's end (distance from the maximum), and maximum number of fits.
PRECISION, MOST_FITS = 1e-3, 30
#: Initial distance from the maximum when searching for an interval's end, in the model's units.
FIRST_STEP = 0.3
#: Smallest initial standard deviation between people: at 0 the gradient is 0 by symmetry.
AWAY_FROM_ZERO = 0.3


class Prediction(NamedTuple):
    """Log probabilities of yes and no, (kinds, outer nodes, inner nodes), and their derivatives.

    ``gradient`` returns the gradient of the log likelihood, given the weight of each yes and each
    no.
    """

    log_yes: Array
    log_no: Array
    gradient: Callable[[Array, Array], Array]


class Predict(Protocol):
    """A model's predictions of answers, given parameters and nodes of the random effects."""

    def __call__(self, theta: Array, outer: Array, inner: Array) -> Prediction:
        """Return the prediction; ``outer`` has shape (effects, nodes, 1), ``inner`` (nodes,)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Counted:
    """Answer counts per person and kind.

    Parameters
    ----------
    yes, no : array, shape (people, kinds)
    cells : int array, shape (kinds,)
        The cell of each kind, from 0.
    times : array, shape (people,)
        How often each row of counts occurs.
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
    """A likelihood's maximum: its location, and the log likelihood there with its gradient."""

    theta: Array
    log_likelihood: float
    gradient: Array


class Interval(NamedTuple):
    """A parameter's estimate (None if the likelihood has no maximum) and the interval's ends."""

    value: float | None
    low: float
    high: float


class Grid(NamedTuple):
    """Nodes of standard normal variables, (effects, nodes), and the logarithms of their weights."""

    nodes: Array
    log_weights: Array

    def crossed(self, other: Grid) -> Grid:
        """Return all combinations of the nodes of two grids."""
        first, second = len(self.log_weights), len(other.log_weights)
        return Grid(
            np.concatenate([np.repeat(self.nodes, second, 1), np.tile(other.nodes, (1, first))]),
            np.repeat(self.log_weights, second) + np.tile(other.log_weights, first),
        )


#: Placeholder for an effect that is left out.
NO_EFFECT = Grid(np.zeros((1, 1)), np.zeros(1))


def even(count: int, farthest: float = FARTHEST_NODE) -> Grid:
    """Return an evenly spaced grid of one variable."""
    found = np.linspace(-farthest, farthest, count)
    return Grid(found[None], -(found**2) / 2 - log(np.exp(-(found**2) / 2).sum()))


def students_fall(people: int, df: int, confidence: float) -> float:
    """Return the drop in log likelihood at the ends of an interval (see the module)."""
    from scipy import stats  # noqa: PLC0415 - takes half a second to import

    t = float(stats.t.ppf((1 + confidence) / 2, df))
    return people / 2 * log(1 + t**2 / df)


class IntegratedModel:
    """A model with random effects for people, fitted by maximum marginal likelihood.

    Parameters
    ----------
    counted : Counted
    predict : Predict
    bounds : sequence of (float, float)
        Bounds of each parameter; equal bounds hold it fixed.
    spreads : collection of int
        Indices of the parameters that are standard deviations of random effects.
    outer, inner : Grid
        Grids for a participant's effects, and for the effect of a cell.
    more : callable, optional
        Returns the log likelihood of answers without random effects, and its gradient.
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
    ) -> None:
        self.counted, self.predict, self.bounds = counted, predict, tuple(bounds)
        self._more = more
        self.spreads = tuple(spreads)
        self.outer, self.inner = outer, inner
        self._cells = [np.flatnonzero(counted.cells == c) for c in np.unique(counted.cells)]

    def posteriors(self, theta: Array) -> tuple[Array, Array]:
        """Return each row's log likelihood, and its probabilities of the outer nodes."""
        told = self._predicted(theta)
        logs, shares, _ = self._integrated(told)
        return logs, shares

    def _predicted(self, theta: Array) -> Prediction:
        return self.predict(theta, self.outer.nodes[:, :, None], self.inner.nodes[0])

    def _integrated(self, told: Prediction) -> tuple[Array, Array, list[Array]]:
        """Return log likelihoods, probabilities of outer nodes and, by cell, of inner nodes."""
        total = self.outer.log_weights
        within = []
        for kinds in self._cells:
            yes, no = self.counted.yes[:, kinds], self.counted.no[:, kinds]
            terms = np.tensordot(yes, told.log_yes[kinds], 1)
            terms += np.tensordot(no, told.log_no[kinds], 1)
            logs, share = _log_sum(terms + self.inner.log_weights)
            within.append(share)
            total = total + logs
        logs, shares = _log_sum(total)
        return logs, shares, within

    def minus_log(self, theta: Array) -> tuple[float, Array]:
        """Return minus the log likelihood and its gradient."""
        told = self._predicted(theta)
        logs, shares, within = self._integrated(told)
        weights = shares * self.counted.times[:, None]
        pull_yes, pull_no = np.empty_like(told.log_yes), np.empty_like(told.log_no)
        for kinds, share in zip(self._cells, within, strict=True):
            here = weights[:, :, None] * share
            pull_yes[kinds] = np.tensordot(self.counted.yes[:, kinds].T, here, 1)
            pull_no[kinds] = np.tensordot(self.counted.no[:, kinds].T, here, 1)
        value, gradient = float(self.counted.times @ logs), told.gradient(pull_yes, pull_no)
        if self._more is not None:
            own, slope = self._more(theta)
            value, gradient = value + own, gradient + slope
        return -value, -gradient

    def fit(self, start: Array, held: Mapping[int, float] | None = None) -> Maximum:
        """Return the maximum, with some parameters held fixed."""
        from scipy import optimize  # noqa: PLC0415

        bounds, start = list(self.bounds), np.array(start, float)
        for place in self.spreads:
            start[place] = max(start[place], min(AWAY_FROM_ZERO, bounds[place][1]))
        for place, value in (held or {}).items():
            bounds[place] = (value, value)
        start = np.clip(start, *np.transpose(bounds))
        found = optimize.minimize(self.minus_log, start, jac=True, method="L-BFGS-B", bounds=bounds)
        return Maximum(np.asarray(found.x), -float(found.fun), -np.asarray(found.jac))

    def profile(self, best: Maximum, place: int, fall: float) -> Interval:
        """Return a parameter with the ends of its interval.

        Parameters
        ----------
        best : Maximum
            Result of `fit` with nothing held.
        fall : float
            Drop in log likelihood, such as `students_fall` returns.
        """
        ends: list[float] = []
        flat = False
        for edge in self.bounds[place]:
            end, likeliest, level = self._end(best, place, edge, fall)
            if likeliest.log_likelihood > best.log_likelihood + FLAT:
                # With the parameter held at another value, the search may get further than the free
                # one, which may even return to the lower maximum.
                freed = self.fit(likeliest.theta)
                higher = max(likeliest, freed, key=lambda each: each.log_likelihood)
                return self.profile(higher, place, fall)
            ends.append(end)
            flat = flat or level
        return Interval(None if flat else float(best.theta[place]), *ends)

    def _end(
        self, best: Maximum, place: int, edge: float, fall: float
    ) -> tuple[float, Maximum, bool]:
        """Search outwards for the point at which the profile likelihood has fallen by ``fall``.

        The square root of the fall is nearly linear in the parameter, so few Newton steps are
        needed.

        Returns
        -------
        end : float
            Infinite if the profile falls by less up to the edge.
        likeliest : Maximum
            Best fit found during the search.
        flat : bool
            Whether the profile does not fall at all up to the edge.
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
                return float(np.copysign(inf, edge - best.theta[place])), likeliest, fallen < FLAT
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
    """Return the logarithm of the sum over the last axis, and each term's proportion of it."""
    if terms.shape[-1] == 1:
        return terms[..., 0], np.ones_like(terms)
    top = terms.max(axis=-1, keepdims=True)
    share = np.exp(terms - top)
    total = share.sum(axis=-1, keepdims=True)
    return (top + np.log(total))[..., 0], share / total
