"""d' by a probit model with participants: each step size its own d', one criterion a person.

    P(yes | step of size s, participant i) = Φ(d'_s - c - σ u_i),   u_i normal; catch: d' = 0

The likelihood is integrated over u on a grid; intervals are the profile likelihood's. Neither needs
a correction for counts of 0 or of all: where every step was felt, or no catch step was, the
interval has no upper bound and the lower one says what the counts allow.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.json_form import renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, few
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval, key_of
from slipscale.analysis.statistics.not_computed import NotComputed

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

#: The normal distribution of participants is summed on a grid: so many points, so far out. Of many
#: answers a participant's likelihood is a narrow peak, which Gauss and Hermite's few points miss:
#: their sum has several maxima.
NODES, FARTHEST_NODE = 241, 6.0
#: d', criterion and σ are searched within these; a d' beyond is none that counts can tell.
FARTHEST, LARGEST_SPREAD = 8.0, 4.0
#: The least σ at which a search begins.
AWAY_FROM_ZERO = 0.3
#: A log-likelihood that falls by less than this up to the edge of the search has no maximum.
FLAT = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class DPrimeOfSize:
    """Sensitivity to steps of one size.

    Parameters
    ----------
    removed_um_pp : float
        Size of the step, µm peak to peak; NaN: all sizes together.
    steps, yes : int
        Answers, and those that were "yes".
    d_prime : float or None
        Of a participant, on the scale of the model; None where the likelihood grows without
        end, at ceiling mostly.
    interval : ConfidenceInterval
        Profile likelihood, Student's quantile with n - 1 degrees of freedom; infinite on a side
        on which the counts end.
    """

    removed_um_pp: float
    steps: int
    yes: int
    d_prime: float | None
    interval: ConfidenceInterval

    @property
    def at_ceiling(self) -> bool:
        """Whether counts give a lower bound only."""
        return self.d_prime is None or self.interval.high == inf

    def json_form(self) -> Mapping[str, object]:
        """Return the result under its keys."""
        return renamed(self, interval=key_of(self.interval)) | {"at_ceiling": self.at_ceiling}


def d_primes(
    sizes: Array, felt: Array, who: NDArray[np.intp], confidence: float
) -> tuple[DPrimeOfSize, ...] | NotComputed:
    """Return d' of each size of step.

    Parameters
    ----------
    sizes : array, shape (answers,)
        Amplitude removed, µm peak to peak; 0 on catch steps.
    felt : array, shape (answers,)
        1 for "yes".
    who : int array, shape (answers,)
        0 to participants - 1.
    confidence : float
        Of the intervals.
    """
    kinds, kind = np.unique(sizes, return_inverse=True)
    people = int(who.max()) + 1 if len(who) else 0
    if 0.0 not in kinds:
        return NotComputed("no catch steps: 'yes' cannot be told from a readiness to say yes")
    if people < FEWEST:
        return NotComputed(few("participants", people))
    catch = int(np.flatnonzero(kinds == 0.0)[0])
    shape = (people, len(kinds))
    total = np.bincount(who * len(kinds) + kind, minlength=people * len(kinds)).reshape(shape)
    yes = np.bincount(who * len(kinds) + kind, felt, people * len(kinds)).reshape(shape)
    # Catch steps first; people of the same counts are computed once.
    columns = [catch, *(place for place in range(len(kinds)) if place != catch)]
    counts = np.stack([yes, total - yes], axis=-1)[:, columns]
    patterns, times = np.unique(counts, axis=0, return_counts=True)
    model = _Model(patterns.astype(float), times.astype(float))
    from scipy import stats  # noqa: PLC0415 - a second's import

    drop = float(stats.t.ppf((1 + confidence) / 2, people - 1)) ** 2 / 2
    found = []
    for place, column in enumerate(columns[1:]):
        estimate, low, high = model.profile(place, drop)
        found.append(
            DPrimeOfSize(
                removed_um_pp=float(kinds[column]),
                steps=int(total[:, column].sum()),
                yes=int(yes[:, column].sum()),
                d_prime=estimate,
                interval=ConfidenceInterval(low, high, confidence),
            )
        )
    return tuple(found)


class _Model:
    """The likelihood of counts, shape (patterns, kinds, 2); kind 0 is the catch step."""

    def __init__(self, counts: Array, times: Array) -> None:
        self.nodes = np.linspace(-FARTHEST_NODE, FARTHEST_NODE, NODES)
        step = 2 * FARTHEST_NODE / (NODES - 1)
        self.log_weights = -(self.nodes**2) / 2 + np.log(step / np.sqrt(2 * np.pi))
        self.counts, self.times = counts, times
        self.kinds = counts.shape[1]

    def minus_log(self, theta: Array) -> tuple[float, Array]:
        """Return minus the log-likelihood and its gradient at (d'..., criterion, σ)."""
        from scipy import special  # noqa: PLC0415

        d, criterion, spread = theta[:-2], theta[-2], theta[-1]
        where = np.concatenate([[0.0], d])[:, None] - criterion - spread * self.nodes
        yes, no = special.log_ndtr(where), special.log_ndtr(-where)
        terms = self.counts[..., 0] @ yes + self.counts[..., 1] @ no + self.log_weights
        top = terms.max(axis=1, keepdims=True)
        share = np.exp(terms - top)
        total = share.sum(axis=1, keepdims=True)
        log = (top + np.log(total))[:, 0]
        share *= self.times[:, None] / total
        # Density over probability, as logarithms: both underflow far out, their ratio does not.
        density = -(where**2) / 2 - 0.5 * np.log(2 * np.pi)
        slope = (self.counts[..., 0].T @ share) * np.exp(density - yes)
        slope -= (self.counts[..., 1].T @ share) * np.exp(density - no)
        each = slope.sum(axis=1)
        gradient = np.array([*each[1:], -each.sum(), -(slope @ self.nodes).sum()])
        return -float(self.times @ log), -gradient

    def fit(self, start: Array, fixed: dict[int, float]) -> tuple[float, Array]:
        """Return the least minus log-likelihood and where, some coordinates held."""
        from scipy import optimize  # noqa: PLC0415

        bounds = [(-FARTHEST, FARTHEST)] * self.kinds + [(0.0, LARGEST_SPREAD)]
        # The likelihood is the same for σ and -σ: at σ = 0 its slope is 0, and a search that begins
        # there stays there.
        start = np.append(start[:-1], max(float(start[-1]), AWAY_FROM_ZERO))
        for place, value in fixed.items():
            bounds[place] = (value, value)
            start = np.where(np.arange(len(start)) == place, value, start)
        found = optimize.minimize(self.minus_log, start, jac=True, method="L-BFGS-B", bounds=bounds)
        return float(found.fun), np.asarray(found.x)

    def profile(self, place: int, drop: float) -> tuple[float | None, float, float]:
        """Return d' of one kind and where the log-likelihood has fallen by ``drop``."""
        from scipy import optimize  # noqa: PLC0415

        start = np.array([1.0] * (self.kinds - 1) + [0.5, 0.5])
        least, best = self.fit(start, {})
        edges = (-FARTHEST, FARTHEST)
        # At the edge, held there, an optimiser may find what the free search stopped short of.
        for end in edges:
            held, there = self.fit(best, {place: end})
            least, best = min((least, best), (held, there), key=lambda pair: pair[0])

        @cache  # the edges are needed several times
        def fallen(value: float) -> float:
            return 0.0 if value == best[place] else self.fit(best, {place: value})[0] - least

        ends = [
            float(optimize.brentq(lambda d: fallen(d) - drop, best[place], end, xtol=1e-3))
            if fallen(end) > drop
            else float(np.copysign(inf, end))
            for end in edges
        ]
        # A maximum at the edge of the search is no maximum.
        flat = any(fallen(end) < FLAT for end in edges)
        return None if flat else float(best[place]), ends[0], ends[1]
