"""Compute confidence intervals for the proportion of "yes" answers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval


def exact_interval(yes: float, n: float, confidence: float = 0.95) -> ConfidenceInterval:
    """Return the exact Clopper-Pearson interval for a proportion of independent answers."""
    from statsmodels.stats.proportion import proportion_confint

    low, high = proportion_confint(yes, n, alpha=1 - confidence, method="beta")
    return ConfidenceInterval(
        float(np.nan_to_num(low, nan=0.0)), float(np.nan_to_num(high, nan=1.0)), confidence
    )


def clustered_interval(
    yes: NDArray[np.float64], answers: NDArray[np.float64], confidence: float = 0.95
) -> ConfidenceInterval:
    """Return an interval for a proportion that allows for correlated answers of a participant.

    Computes the Clopper-Pearson interval for the effective sample size, which is the number of
    answers divided by the design effect (Korn and Graubard 1998, Survey Methodology 24, 193-201),
    with a t-based correction for few participants. If all answers are the same, each participant
    counts as one answer. With one answer per participant, the interval is the ordinary
    Clopper-Pearson interval.

    Parameters
    ----------
    yes, answers : array, shape (participants,)
        Number of "yes" answers and number of all answers (at least 1) of each participant.
    """
    from scipy import stats

    people, total = len(answers), float(answers.sum())
    share = float(yes.sum()) / total
    if people == total:
        return exact_interval(share * total, total, confidence)
    if people == 1:
        return ConfidenceInterval(0.0, 1.0, confidence)
    independent = share * (1 - share) / total
    left = yes - share * answers
    clustered = people / (people - 1) * float((left**2).sum()) / total**2
    effective = float(people)
    if independent > 0:
        alike = max(clustered / independent, 1.0)
        tail = (1 - confidence) / 2
        few = stats.t.ppf(tail, total - 1) / stats.t.ppf(tail, people - 1)
        effective = min(total / alike * float(few) ** 2, total)
    return exact_interval(share * effective, effective, confidence)
