"""Compute the mean of one value per participant, its t-based interval and its t test against 0."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.json_form import renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY, few
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.holm import holm
from slipscale.analysis.statistics.not_computed import NotComputed


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimatedMean:
    """A mean across participants with its interval, if a test against 0 is meaningless.

    Parameters
    ----------
    mean, sd : float
        Mean and sample standard deviation (n - 1), in the unit of the values.
    interval : ConfidenceInterval
        t-based confidence interval for the mean.
    """

    mean: float
    interval: ConfidenceInterval
    sd: float

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, interval="ci")


@dataclass(frozen=True, slots=True, kw_only=True)
class MeanOverParticipants(EstimatedMean):
    """A mean across participants, with its interval and its t test against 0.

    Parameters
    ----------
    mean, sd, interval : object
        See `EstimatedMean`.
    t, df, p : float, int, float
        Two-sided t test of the mean against 0.
    """

    t: float
    df: int
    p: float


def mean_over_participants(
    values: NDArray[np.float64],
    confidence: float,
    possible: tuple[float, float] = (-inf, inf),
) -> MeanOverParticipants | NotComputed:
    """Return the mean of one value per participant, its t-based interval and its t test against 0.

    Parameters
    ----------
    values : array, shape (participants,)
        Non-finite values are omitted.
    confidence : float
        Confidence level of the interval.
    possible : tuple of float
        Smallest and largest possible value, such as the ends of a scale. The interval ends there at
        the latest, which does not change its coverage.
    """
    from scipy import stats

    values = values[np.isfinite(values)]
    if len(values) < FEWEST:
        return NotComputed(few("participants", len(values)))
    if np.ptp(values) <= TINY * max(float(np.abs(values).max()), 1.0):
        return NotComputed("all participants have the same value, so no test is possible")
    found = stats.ttest_1samp(values, 0.0)
    ends = found.confidence_interval(confidence)
    low, high = max(float(ends.low), possible[0]), min(float(ends.high), possible[1])
    return MeanOverParticipants(
        mean=float(values.mean()),
        interval=ConfidenceInterval(low, high, confidence),
        sd=float(values.std(ddof=1)),
        t=float(found.statistic),
        df=len(values) - 1,
        p=float(found.pvalue),
    )


def estimated_mean(
    values: NDArray[np.float64],
    confidence: float,
    possible: tuple[float, float] = (-inf, inf),
) -> EstimatedMean | NotComputed:
    """Return what `mean_over_participants` returns, without the test.

    Use it for values that differ from 0 by nature, such as times and thresholds.
    """
    found = mean_over_participants(values, confidence, possible)
    if not found:
        return found
    return EstimatedMean(mean=found.mean, interval=found.interval, sd=found.sd)


def unbounded(
    found: MeanOverParticipants | NotComputed, *, below: bool, above: bool
) -> MeanOverParticipants | NotComputed:
    """Return a mean whose interval has no lower or upper bound.

    Use it if some values are only bounds, such as d' of a participant without a single error: the
    log-linear correction gives a finite value for any d' beyond it, so that the mean and the upper
    end of its interval are too small, but the lower end is valid.
    """
    if not found:
        return found
    low, high = found.interval
    ends = ConfidenceInterval(
        -inf if below else low, inf if above else high, found.interval.confidence
    )
    return replace(found, interval=ends)


def holm_of(found: Sequence[MeanOverParticipants | NotComputed]) -> list[float | None]:
    """Return the Holm-corrected p-values of a family of tests, with None for missing results."""
    ps = holm([each.p if each else np.nan for each in found])
    return [p if each else None for p, each in zip(ps, found, strict=True)]
