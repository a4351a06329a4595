"""Compute the tests of the report for thousands of simulated tables at once.

A table has one row per participant and one column per stimulus. Unless stated otherwise, a
function takes an array of tables, shape (tables, participants, columns), and returns one value per
table.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.statistics.arrays import Array
from slipscale.analysis.statistics.regression import fit_lines
from slipscale.analysis.statistics.repeated_measures.pairwise import EXACT_AT_MOST


def repeated_measures_f(tables: Array) -> Array:
    """Return the one-way repeated-measures F, which is infinite if only the error is zero."""
    _, n, k = tables.shape
    x = tables - tables.mean(axis=(1, 2), keepdims=True)
    between = n * (x.mean(axis=1) ** 2).sum(axis=1)
    participants = k * (x.mean(axis=2) ** 2).sum(axis=1)
    total = (x**2).sum(axis=(1, 2))
    error = total - between - participants
    # What is zero except for rounding is set to zero: equal sums give an F of 0.
    between, error = (np.where(part > 1e-12 * total, part, 0.0) for part in (between, error))
    return _ratio(between * (n - 1), error, _limit(between))


def interactions(tables: Array) -> Array:
    """Remove the main effects of two factors from cell means.

    To test the interaction, pass the result to `repeated_measures_f` and `greenhouse_geisser`.

    Parameters
    ----------
    tables : array, shape (tables, participants, first, second)

    Returns
    -------
    array, shape (tables, participants, first x second)
    """
    rest: Array = tables - tables.mean(axis=3, keepdims=True)
    rest -= rest.mean(axis=2, keepdims=True)
    return rest.reshape(*tables.shape[:2], -1)


def greenhouse_geisser(tables: Array, df: int | None = None) -> Array:
    """Return Greenhouse and Geisser's epsilon (1959), which measures departure from sphericity.

    ``df`` is the effect's degrees of freedom. The default is the number of columns minus 1.
    """
    _, n, k = tables.shape
    x = tables - tables.mean(axis=1, keepdims=True)
    x = x - x.mean(axis=2, keepdims=True)
    covariance = np.swapaxes(x, 1, 2) @ x / (n - 1)
    trace = np.trace(covariance, axis1=1, axis2=2)
    squares = (covariance**2).sum(axis=(1, 2))
    # Without variation there is no departure from sphericity.
    return _ratio(trace**2, (df or k - 1) * squares, 1.0)


def friedman(tables: Array) -> Array:
    """Return Friedman's chi-square with the correction for ties, or 0 if all ratings are tied."""
    _, n, k = tables.shape
    here, there = tables[:, :, :, None], tables[:, :, None, :]
    equal = (here == there).sum(axis=3)
    ranks = (here > there).sum(axis=3) + (equal + 1) / 2
    spread = ((ranks.sum(axis=1) - n * (k + 1) / 2) ** 2).sum(axis=1)
    ties = (equal**2 - 1).sum(axis=(1, 2)) / (n * k * (k**2 - 1))
    scale = n * k * (k + 1) / 12 * (1 - ties)
    return _ratio(spread, scale, 0.0)


def friedman_p(tables: Array) -> Array:
    """Return the p-value of Friedman's test, or 1 if all ratings are tied."""
    from scipy import stats

    return np.asarray(stats.chi2.sf(friedman(tables), tables.shape[2] - 1))


def signed_rank_p(differences: Array) -> Array:
    """Return Wilcoxon's two-sided p-value for each row, or 1 if all its differences are zero.

    Differences of zero are omitted, and tied absolute differences share their mean rank. Without
    ties, the p-value is exact for up to `EXACT_AT_MOST` nonzero differences.

    Parameters
    ----------
    differences : array, shape (tables, participants)
        Paired differences, with NaN for missing values.
    """
    from scipy import stats

    step = np.where(np.isnan(differences), 0.0, differences)
    up = step > 0
    changed = np.count_nonzero(step, axis=1)
    # Zeros have the lowest ranks, so omitting them lowers every other rank by their number.
    ranks = stats.rankdata(np.abs(step), axis=1) - (step.shape[1] - changed)[:, None]
    rank_sum = np.where(up, ranks, 0.0).sum(axis=1)
    p = np.ones(len(step))
    small = changed <= EXACT_AT_MOST
    p[small] = _exact_p(rank_sum[small], changed[small])
    if not small.all():
        p[~small] = stats.wilcoxon(step[~small], axis=1, method="asymptotic").pvalue
    return p


def _exact_p(rank_sum: Array, changed: NDArray[np.int64]) -> Array:
    """Return exact two-sided p-values for sums of positive ranks, given the numbers of ranks.

    With ties, a sum may not be a whole number. As in SciPy, it is rounded up or down, whichever
    gives the larger p-value.
    """
    all_ranks = changed * (changed + 1) // 2
    # The distribution is symmetrical, so the upper tail is computed as a lower tail.
    extreme = np.minimum(np.ceil(rank_sum), all_ranks - np.floor(rank_sum)).astype(np.int64)
    return np.asarray(np.minimum(2 * _rank_sums()[changed, extreme], 1.0))


@cache
def _rank_sums() -> Array:
    """Return the distribution of the sum of positive ranks: P(sum <= s) at [n, s].

    Under the null hypothesis, each rank is positive with probability 1/2. The distribution for n
    ranks is therefore the average of the distribution for n - 1 ranks and the same distribution
    shifted by n (Wilcoxon, 1945, Biometrics Bulletin 1, 80-83).
    """
    most = EXACT_AT_MOST * (EXACT_AT_MOST + 1) // 2
    share = np.zeros((EXACT_AT_MOST + 1, most + 1))
    share[0, 0] = 1.0
    for n in range(1, EXACT_AT_MOST + 1):
        share[n] = share[n - 1] / 2
        share[n, n:] += share[n - 1, :-n] / 2
    return np.cumsum(share, axis=1)


def paired_t(tables: Array) -> Array:
    """Return the paired t statistic of column 2 minus column 1, for tables with two columns."""
    difference = tables[:, :, 1] - tables[:, :, 0]
    mean, error = difference.mean(axis=1), difference.std(axis=1, ddof=1)
    return _ratio(mean * np.sqrt(tables.shape[1]), error, _limit(mean))


def exponents(tables: Array, log_amplitude: Sequence[float]) -> Array:
    """Return each participant's exponent: the regression slope of log rating on log amplitude.

    A rating of zero has no logarithm and is treated as missing, as in the analysis of raw data.

    Returns
    -------
    ndarray, shape (tables, participants)
        NaN for participants with fewer than two ratings above zero.
    """
    y = np.log(tables, out=np.full(tables.shape, np.nan), where=tables > 0)
    return fit_lines(np.asarray(log_amplitude, dtype=np.float64), y).slope


def mean_exponent(tables: Array, log_amplitude: Sequence[float]) -> Array:
    """Return the mean of participants' exponents, ignoring missing exponents."""
    found = exponents(tables, log_amplitude)
    return _ratio(np.nansum(found, axis=1), np.isfinite(found).sum(axis=1), np.nan)


def sd_of_exponents(tables: Array, log_amplitude: Sequence[float]) -> Array:
    """Return the standard deviation (n - 1) of the participants' exponents."""
    found = exponents(tables, log_amplitude)
    number = np.isfinite(found).sum(axis=1)
    squares = (found - mean_exponent(tables, log_amplitude)[:, None]) ** 2
    return np.sqrt(_ratio(np.nansum(squares, axis=1), number - 1, np.nan))


def _limit(top: Array) -> Array:
    """Return the limit of ``top / error`` at an error of 0: ±infinity, or 0 if ``top`` is 0."""
    return np.where(top == 0, 0.0, np.copysign(np.inf, top))


def _ratio(top: Array, bottom: Array, otherwise: Array | float) -> Array:
    out = np.broadcast_to(otherwise, top.shape).astype(np.float64)
    found: Array = np.divide(top, bottom, out=out, where=bottom > 0)
    return found
