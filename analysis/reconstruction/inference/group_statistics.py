"""Compute test statistics of independent groups, and compare them with published tests."""

from __future__ import annotations

from math import nan, sqrt
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.inference.printed_windows import (
    SLACK,
    fits,
    p_between,
    size_of,
)

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.table.printed_tests import PrintedTest


def of_groups(test: PrintedTest, means: Array, variances: Array, n: Array) -> tuple[Array, Array]:
    """Return the test statistic and p for each row of `means` and `variances`.

    The p-value is the upper-tail probability of F, or the two-sided p of t.
    """
    from scipy.stats import f as fisher
    from scipy.stats import t as student

    k, total = len(n), int(n.sum())
    within = ((n - 1) * variances).sum(axis=1)
    bottom = np.where(within > 0, within, nan)
    if test.kind == "one_way_f":
        centre = (n * means).sum(axis=1, keepdims=True) / total
        between = (n * (means - centre) ** 2).sum(axis=1) / (k - 1)
        values = between / (bottom / (total - k))
        return values, fisher.sf(values, k - 1, total - k)
    of_mean = variances / n
    if test.kind == "welch_t":
        squared = of_mean.sum(axis=1)
        degrees = squared**2 / np.where(within > 0, (of_mean**2 / (n - 1)).sum(axis=1), nan)
        values = (means[:, 1] - means[:, 0]) / np.sqrt(np.where(within > 0, squared, nan))
    else:
        degrees = np.full(len(means), float(total - k))
        values = (means[:, 1] - means[:, 0]) / np.sqrt(bottom / (total - k) * (1 / n).sum())
    return values, 2 * student.sf(np.abs(values), degrees)


def prints(test: PrintedTest, values: Array, p: Array, n: Array) -> Array:
    """Return a mask of the statistics and p-values that match the published test."""
    low, high = p_between(test)
    left = fits(p * test.sides / 2 if test.kind != "one_way_f" else p, (low, high))
    if test.p_below is not None:
        left &= p * (test.sides / 2 if test.kind != "one_way_f" else 1) < high + SLACK
    size = np.abs(values)
    left &= fits(size, size_of(test.statistic, test.rounding))
    if test.d is not None:
        left &= fits(size * sqrt((1 / n).sum()), size_of(test.d, test.rounding))
    if test.partial_eta_squared is not None:
        degrees = len(n) - 1, int(n.sum()) - len(n)
        share = values * degrees[0] / (values * degrees[0] + degrees[1])
        left &= fits(share, size_of(test.partial_eta_squared, test.rounding))
    return left
