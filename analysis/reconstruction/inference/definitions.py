"""Compute test statistics of ratings directly from their definitions.

Verdicts are derived from sums, sums of squares and sums of products. In contrast, this module
computes statistics from the ratings themselves, so that it provides an independent check of
examples and counterexamples.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array

    Groups = Sequence[Array]


def paired_t(columns: Groups) -> Array:
    """Return paired t for the second column minus the first, or NaN if no difference varies."""
    differences = columns[1] - columns[0]
    return _ratio(
        differences.mean(axis=1), differences.std(axis=1, ddof=1) / np.sqrt(differences.shape[1])
    )


def independent_t(columns: Groups) -> Array:
    """Return Student's t for the second group minus the first, or NaN if neither group varies."""
    a, b = columns
    n = a.shape[1], b.shape[1]
    pooled = ((n[0] - 1) * a.var(axis=1, ddof=1) + (n[1] - 1) * b.var(axis=1, ddof=1)) / (
        sum(n) - 2
    )
    return _ratio(b.mean(axis=1) - a.mean(axis=1), np.sqrt(pooled * (1 / n[0] + 1 / n[1])))


def welch_t(columns: Groups) -> Array:
    """Return Welch's t for the second group minus the first, or NaN if neither group varies."""
    a, b = columns
    squared = sum(x.var(axis=1, ddof=1) / x.shape[1] for x in (a, b))
    return _ratio(b.mean(axis=1) - a.mean(axis=1), np.sqrt(squared))


def one_way_f(columns: Groups) -> Array:
    """Return the one-way F, or NaN without variation within groups."""
    n = [x.shape[1] for x in columns]
    grand = np.concatenate(list(columns), axis=1).mean(axis=1)
    between = sum(m * (x.mean(axis=1) - grand) ** 2 for m, x in zip(n, columns, strict=True))
    within = sum(((x - x.mean(axis=1, keepdims=True)) ** 2).sum(axis=1) for x in columns)
    return _ratio(between / (len(n) - 1), within / (sum(n) - len(n)))


def rm_f(columns: Groups) -> Array:
    """Return the repeated-measures F, or NaN if the error sum of squares is 0."""
    x = np.stack(list(columns), axis=2).astype(float)
    n, k = x.shape[1:]
    means = x.mean(axis=1, keepdims=True)
    own = x.mean(axis=2, keepdims=True)
    grand = x.mean(axis=(1, 2), keepdims=True)
    error = ((x - means - own + grand) ** 2).sum(axis=(1, 2)) / ((n - 1) * (k - 1))
    between = n * ((means - grand) ** 2).sum(axis=(1, 2)) / (k - 1)
    return _ratio(between, error)


def correlation(columns: Groups) -> Array:
    """Return Pearson's r, or NaN if a column is constant."""
    a, b = (x - x.mean(axis=1, keepdims=True) for x in columns)
    return _ratio((a * b).sum(axis=1), np.sqrt((a**2).sum(axis=1) * (b**2).sum(axis=1)))


STATISTICS: dict[str, Callable[[Groups], Array]] = {
    "paired_t": paired_t,
    "independent_t": independent_t,
    "welch_t": welch_t,
    "one_way_f": one_way_f,
    "rm_f": rm_f,
    "correlation": correlation,
}


def _ratio(top: Array, bottom: Array) -> Array:
    # Sums of squares that are exactly 0 may be around 1e-31 in floating point.
    defined = bottom > 1e-12 * (1 + np.abs(top))
    found: Array = np.divide(top, bottom, out=np.full_like(bottom, np.nan), where=defined)
    return found
