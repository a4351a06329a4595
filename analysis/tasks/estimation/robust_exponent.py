"""Estimate an exponent that is robust against lapses and outlying participants.

A lapse changes a participant's least-squares slope, but has little effect on the median slope
between pairs of trials (Theil 1950; Sen 1968). An outlying participant changes the mean exponent,
but has little effect on the 20 % trimmed mean (Tukey and McLaughlin 1963). Robust exponents
supplement the mean exponent as a sensitivity analysis.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.json_form import renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval, key_of
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.power_law import too_few_slopes
from slipscale.experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from slipscale.analysis.preprocessing.log_transform import Prepared

#: Proportion of exponents trimmed at each end.
TRIMMED = 0.2


@dataclass(frozen=True, slots=True, kw_only=True)
class RobustExponent:
    """The trimmed mean of participants' Theil-Sen slopes.

    Parameters
    ----------
    exponent : float
    interval : ConfidenceInterval
        Tukey-McLaughlin interval across participants.
    n, trimmed : int
        Number of participants with a slope, and total number of slopes trimmed at both ends.
    """

    exponent: float
    interval: ConfidenceInterval
    n: int
    trimmed: int

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, interval=key_of(self.interval))


def median_slope(x: NDArray[np.float64], y: NDArray[np.float64]) -> float:
    """Return the median of the slopes between all pairs of points with different `x`.

    Notes
    -----
    The result equals `scipy.stats.theilslopes(y, x).slope`, which is slower because it also
    computes an interval.
    """
    order = np.argsort(x, kind="stable")
    x, y = x[order], y[order]
    ends = np.flatnonzero(np.diff(x)) + 1  # where x changes
    slopes = [
        (y[end:, None] - y[start:end]) / (x[end:, None] - x[start])
        for start, end in zip((0, *ends), ends, strict=False)
    ]
    # `numpy.median` places three values in order, which takes three times as long as one.
    ordered = np.concatenate(slopes, axis=None)
    middle = len(ordered) // 2
    ordered.partition(middle)
    below = ordered[middle] if len(ordered) % 2 else ordered[:middle].max()
    return float((below + ordered[middle]) / 2)


def robust_exponent(data: Prepared) -> RobustExponent | NotComputed:
    """Return the robust exponent from all trials with a log estimate and an amplitude above 0."""
    from scipy import stats

    if data.refused:
        return NotComputed(data.zero_sentence)
    usable = (data.trials["level"] > 0) & data.trials["log"].notna()
    trials = data.trials[usable]
    x = np.log(trials["level"].to_numpy(float))
    y = trials["log"].to_numpy(float)
    people = trials.groupby(PARTICIPANT, observed=True).indices.values()
    slopes = [median_slope(x[own], y[own]) for own in people if np.ptp(x[own]) > 0]
    n = len(slopes)
    if n < FEWEST:
        return too_few_slopes(n, data.quantity)
    if np.ptp(slopes) == 0:
        return NotComputed("all participants have the same value, so there is no spread")
    ordered, cut = np.sort(slopes), int(TRIMMED * n)
    kept, confidence = n - 2 * cut, data.choices.confidence
    winsorised = np.clip(ordered, ordered[cut], ordered[n - cut - 1])
    squares = float(((winsorised - winsorised.mean()) ** 2).sum())
    half = float(stats.t.ppf((1 + confidence) / 2, kept - 1)) * (squares / kept / (kept - 1)) ** 0.5
    exponent = float(ordered[cut : n - cut].mean())
    return RobustExponent(
        exponent=exponent,
        interval=ConfidenceInterval(exponent - half, exponent + half, confidence),
        n=n,
        trimmed=2 * cut,
    )
