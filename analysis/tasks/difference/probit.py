"""Estimate d' for each step size with a probit model that has random participant effects.

    P(yes | step of size s, participant i) = Φ(d'_s + τ v_i - c - σ u_i)
    P(yes | catch step, participant i)     = Φ(-c - σ u_i),   u_i and v_i normal

Both the criterion and the sensitivity differ between people. If sensitivities have a standard
deviation of 0.4, intervals from a model without the term τ v_i contain the true value in only 80 to
90 % of simulations. The likelihood is integrated over u and v; confidence intervals use the profile
likelihood. Proportions of 0 or 1 need no correction. If participants felt every step, or no catch
step, the interval has only a lower bound. If all answers to steps and catch steps are alike, d' is
not determined, and the interval is unbounded.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, isfinite

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.json_form import renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, few
from slipscale.analysis.statistics.arrays import Array
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval, key_of
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.integrated_over_people import (
    NO_EFFECT,
    Counted,
    IntegratedModel,
    Prediction,
    even,
    students_fall,
)

#: Search ranges for d', criterion and standard deviations. Larger values of d' cannot be estimated
#: from counts.
FARTHEST, LARGEST_SPREAD = 8.0, 4.0
#: Smallest mean number of answers per participant, to steps and to catch steps, for which τ is
#: estimated. With fewer answers, τ is set to 0, because differences in sensitivity cannot be
#: separated from differences in criterion. When τ was estimated from three steps and one catch
#: step, the median d' was 15 % too large (30 people, d' = 3).
FEWEST_OF_A_KIND = 5
#: Smallest and largest number of nodes for u and v.
FEWEST_NODES, MOST_NODES = 15, 161
#: Number of integration nodes for u, divided by the square root of a participant's number of
#: answers. There are half as many nodes for v.
NODES = 8.0


@dataclass(frozen=True, slots=True, kw_only=True)
class DPrimeOfSize:
    """Sensitivity to steps of one size.

    Parameters
    ----------
    removed_level : float
        Step size in µm peak to peak; NaN for all sizes combined.
    steps, yes : int
        Counts of answers and of "yes" answers.
    d_prime : float or None
        d' of a typical participant. None if the likelihood has no maximum, usually because all
        steps were felt.
    interval : ConfidenceInterval
        Profile-likelihood interval with a t quantile (n - 1 degrees of freedom). A bound is
        infinite if the counts do not determine it.
    """

    removed_level: float
    steps: int
    yes: int
    d_prime: float | None
    interval: ConfidenceInterval

    @property
    def at_ceiling(self) -> bool:
        """Whether the counts determine only a lower bound of d'."""
        return isfinite(self.interval.low) and self.interval.high == inf

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, interval=key_of(self.interval)) | {"at_ceiling": self.at_ceiling}


def d_primes(
    sizes: Array, felt: Array, who: NDArray[np.intp], confidence: float
) -> tuple[DPrimeOfSize, ...] | NotComputed:
    """Return d' for each step size.

    Parameters
    ----------
    sizes : array, shape (answers,)
        Amplitude removed, in µm peak to peak; 0 for catch steps.
    felt : array, shape (answers,)
        1 for "yes" and 0 for "no".
    who : int array, shape (answers,)
        Participant indices, 0 to participants - 1.
    confidence : float
        Confidence level of the intervals.
    """
    kinds, kind = np.unique(sizes, return_inverse=True)
    people = int(who.max()) + 1 if len(who) else 0
    if 0.0 not in kinds:
        return NotComputed(
            "there are no catch steps, so sensitivity cannot be separated from a tendency "
            "to answer “yes”"
        )
    if people < FEWEST:
        return NotComputed(few("participants", people))
    catch = int(np.flatnonzero(kinds == 0.0)[0])
    shape = (people, len(kinds))
    total = np.bincount(who * len(kinds) + kind, minlength=people * len(kinds)).reshape(shape)
    yes = np.bincount(who * len(kinds) + kind, felt, people * len(kinds)).reshape(shape)
    # Catch steps come first. The likelihood is computed once for all people with the same counts.
    columns = [catch, *(place for place in range(len(kinds)) if place != catch)]
    counts = np.stack([yes, total - yes], axis=-1)[:, columns]
    patterns, times = np.unique(counts, axis=0, return_counts=True)
    counted = Counted(
        yes=patterns[..., 0].astype(float),
        no=patterns[..., 1].astype(float),
        cells=np.minimum(np.arange(len(kinds)), 1),
        times=times.astype(float),
    )
    answers = total[:, columns]
    fewest = min(answers[:, 0].mean(), answers[:, 1:].sum(axis=1).mean())
    differ = bool(fewest >= FEWEST_OF_A_KIND)
    outer = int(np.clip(NODES * counted.most_answers**0.5, FEWEST_NODES, MOST_NODES))
    model = IntegratedModel(
        counted,
        _Probit(len(kinds)),
        [(-FARTHEST, FARTHEST)] * len(kinds)
        + [(0.0, LARGEST_SPREAD), (0.0, LARGEST_SPREAD if differ else 0.0)],
        spreads=(len(kinds), len(kinds) + 1),
        outer=even(outer),
        inner=even(max(outer // 2, FEWEST_NODES)) if differ else NO_EFFECT,
    )
    best = model.fit(np.array([1.0] * (len(kinds) - 1) + [0.5, 0.5, 0.5]))
    fall = students_fall(people, people - 1, confidence)
    # If all answers are alike, the bounds of the search, not the counts, would limit the interval.
    determined = [
        place
        for place, column in enumerate(columns[1:])
        if not _all_alike(yes[:, [catch, column]].sum(), total[:, [catch, column]].sum())
    ]
    intervals = dict(zip(determined, model.profiles(best, determined, fall)[1], strict=True))
    found = []
    for place, column in enumerate(columns[1:]):
        estimate, low, high = intervals.get(place, (None, -inf, inf))
        found.append(
            DPrimeOfSize(
                removed_level=float(kinds[column]),
                steps=int(total[:, column].sum()),
                yes=int(yes[:, column].sum()),
                d_prime=estimate,
                interval=ConfidenceInterval(low, high, confidence),
            )
        )
    return tuple(found)


def _all_alike(yes: float, n: float) -> bool:
    return yes in (0, n)


class _Probit:
    """Probit model with parameters (d'..., criterion, σ, τ). The first kind is the catch step."""

    def __init__(self, kinds: int) -> None:
        # Differences in sensitivity affect steps but not catch steps.
        self.step = np.arange(kinds) > 0

    def __call__(self, theta: Array, outer: Array, inner: Array) -> Prediction:
        """Return the log probabilities of "yes" and "no", each of shape (kinds, outer, inner)."""
        from scipy import special

        d, (criterion, spread, own) = np.append(0.0, theta[:-3]), theta[-3:]
        sensitivity = np.where(self.step[:, None], inner, 0.0)
        where = (d - criterion)[:, None, None] - spread * outer[0] + own * sensitivity[:, None, :]
        yes, no = special.log_ndtr(where), special.log_ndtr(-where)

        def gradient(pull_yes: Array, pull_no: Array) -> Array:
            # Computed on logarithms, because density and probability underflow in the tails, but
            # their ratio does not.
            density = -(where**2) / 2 - 0.5 * np.log(2 * np.pi)
            slope = pull_yes * np.exp(density - yes) - pull_no * np.exp(density - no)
            each = slope.sum(axis=(1, 2))
            return np.array(
                [
                    *each[1:],
                    -each.sum(),
                    -(slope * outer[0]).sum(),
                    (slope * sensitivity[:, None, :]).sum(),
                ]
            )

        return Prediction(yes, no, gradient)
