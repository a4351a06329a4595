"""Compute jackknife tests and intervals across participants."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.preprocessing.sufficiency import TINY
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants
from slipscale.analysis.statistics.not_computed import NotComputed


def jackknife(
    estimate: float, without: NDArray[np.float64], *, confidence: float
) -> MeanOverParticipants | NotComputed:
    """Return an estimate with its t-based interval and t test against 0.

    The standard error is the jackknife estimate (Tukey 1958, Annals of Mathematical Statistics 29,
    614), with n - 1 degrees of freedom. For a regression with clusters, the jackknife error is at
    least as large as the sandwich error, and intervals have nominal coverage even with few clusters
    (Bell and McCaffrey 2002, Survey Methodology 28, 169-181).

    Parameters
    ----------
    estimate : float
        Estimate from all participants.
    without : array, shape (participants,)
        Leave-one-out estimates, each of which omits one participant.
    confidence : float
        Confidence level of the interval.
    """
    from scipy import stats

    n = len(without)
    error = float(np.sqrt((n - 1) / n * ((without - estimate) ** 2).sum()))
    if not error > TINY * max(abs(estimate), 1.0):
        return NotComputed("all participants have the same value, so there is no spread")
    half = float(stats.t.ppf((1 + confidence) / 2, n - 1)) * error
    t = estimate / error
    return MeanOverParticipants(
        mean=estimate,
        interval=ConfidenceInterval(estimate - half, estimate + half, confidence),
        sd=error * n**0.5,
        t=t,
        df=n - 1,
        p=float(2 * stats.t.sf(abs(t), n - 1)),
    )
