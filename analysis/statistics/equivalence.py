"""Test whether two amplitudes are equivalent, by two one-sided tests and by a Bayes factor.

A non-significant difference is not evidence of equality, but these tests can provide such evidence.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, inf, log, log1p, sqrt

import numpy as np

from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants

#: Scale of the Cauchy prior for d_z, as in pingouin, JASP and the R package BayesFactor.
PRIOR_SCALE = 0.707
#: The integral over g, the variance in the prior, is computed at GRID values of log g, from -LOG_G
#: to LOG_G.
LOG_G, GRID = 60.0, 12_001
#: The logarithm of the largest floating-point number.
LARGEST_LOG = 709.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Equivalence:
    """The result of two one-sided tests (TOST) for a ratio of geometric means.

    Parameters
    ----------
    bound : float
        Equivalence bound, a number above 1. A ratio between 1 / bound and bound counts as
        equivalent.
    interval : ConfidenceInterval
        Interval for the ratio at confidence level 1 - 2 α, where α is the significance level. The
        interval lies inside the bounds if and only if ``p`` < α.
    p : float
        The larger of the two one-sided p-values.
    """

    bound: float
    interval: ConfidenceInterval
    p: float


def equivalence(logs: MeanOverParticipants, bound: float) -> Equivalence:
    """Test whether a mean difference of logarithms lies between -log(bound) and log(bound).

    For the method of two one-sided tests, see Schuirmann (1987), Journal of Pharmacokinetics and
    Biopharmaceutics 15, 657-680.

    Parameters
    ----------
    logs : MeanOverParticipants
        Mean of participants' differences. The confidence level of the interval sets the
        significance level: α = 1 - confidence.
    bound : float
        Equivalence bound, a ratio above 1.
    """
    from scipy import stats

    se = logs.sd / sqrt(logs.df + 1)
    above_low, below_high = (log(bound) + logs.mean) / se, (log(bound) - logs.mean) / se
    # A confidence level of 1 - 2 α leaves α in each tail.
    half = float(stats.t.ppf(logs.interval.confidence, logs.df)) * se
    return Equivalence(
        bound=bound,
        interval=ConfidenceInterval(
            exp(logs.mean - half), exp(logs.mean + half), 2 * logs.interval.confidence - 1
        ),
        p=float(stats.t.sf(min(above_low, below_high), logs.df)),
    )


def bayes_factor(t: float, n: int) -> float:
    """Return the Bayes factor for a difference, given the paired t of n differences.

    Computes the Jeffreys–Zellner–Siow Bayes factor (Rouder et al. 2009, Psychonomic Bulletin &
    Review 16, 225-237, eq. 1) as a sum over log g. The prior for d_z is a Cauchy distribution with
    scale `PRIOR_SCALE`. The result is infinite if it exceeds the range of floating-point numbers.
    The package pingouin integrates over g instead, and misses the peak of the integrand if t is
    large: for n = 3 and t = 10,000, it returns a Bayes factor of 48 instead of 6,900. For thousands
    of participants, pingouin computes 0 / 0.

    >>> round(bayes_factor(3.5, 20), 2), round(1 / bayes_factor(0.2, 20), 2)
    (17.18, 4.23)
    """
    log_g, step = np.linspace(-LOG_G, LOG_G, GRID, retstep=True)
    spread = np.log1p(n * PRIOR_SCALE**2 * np.exp(log_g))
    # The integrand contains a factor g, because the grid is uniform in log g.
    density = (
        -spread / 2
        - n / 2 * np.log1p(t**2 / (n - 1) * np.exp(-spread))
        - (log_g + np.log(2 * np.pi) + np.exp(-log_g)) / 2
    )
    peak = density.max()
    log_factor = peak + np.log(np.exp(density - peak).sum() * step) + n / 2 * log1p(t**2 / (n - 1))
    return exp(log_factor) if log_factor < LARGEST_LOG else inf
