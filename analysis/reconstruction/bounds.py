"""What holds in every data set, whoever gave which rating: bounds over two or more columns.

A table never says which rating in one column belongs to which in the next. Every bound here
therefore holds for every pairing. A sharp bound is attained by some pair of data sets that the
table allows; one that is not marked sharp holds all the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from analysis.reconstruction.side import Array

# Products of so many pairs of data sets are searched whole.
SEARCHED = 60_000_000
BLOCK = 2048
# Rows with extreme sums that are tried before all.
CANDIDATES = 200


@dataclass(frozen=True)
class Range:
    """Smallest and largest value over all data sets and pairings, and whether attained."""

    low: float
    high: float
    sharp: bool


def larger(x: Array, y: Array) -> Range:
    """Return how many of n pairs can have y above x, whatever the pairing.

    Parameters
    ----------
    x, y : ndarray of int, shapes (p, n) and (q, n)
        All data sets of two columns, each row sorted.

    Notes
    -----
    At least r pairs can have y > x if and only if the r largest y exceed the r smallest x one
    by one; the others follow from pairs with y <= x in the same way.
    """
    n = x.shape[1]
    most, sure = _largest(y, x, np.greater)
    not_above, sure_too = _largest(x, y, np.greater_equal)
    return Range(n - not_above, most, sharp=sure and sure_too)


def _largest(upper: Array, lower: Array, compare: np.ufunc) -> tuple[int, bool]:
    """Return the largest r for which the r largest `upper` can beat the r smallest `lower`.

    And whether that is sure; if not, it is an upper bound.
    """
    n, sure = upper.shape[1], True
    for r in range(1, n + 1):
        answer = _beats(upper[:, n - r :], lower[:, :r], compare)
        if answer is False:
            return r - 1, sure
        sure = sure and answer is True
    return n, sure


def _beats(upper: Array, lower: Array, compare: np.ufunc) -> bool | None:
    """Whether some row of `upper` beats some row of `lower` everywhere; None: too many."""
    if not compare(upper.max(axis=0), lower.min(axis=0)).all():
        return False
    # Most answers are yes, and rows with extreme sums show it.
    tall = upper[np.argsort(upper.sum(axis=1))[-CANDIDATES:]]
    small = lower[np.argsort(lower.sum(axis=1))[:CANDIDATES]]
    if compare(tall[:, None], small[None]).all(axis=2).any():
        return True
    tall, small = np.unique(upper, axis=0), np.unique(lower, axis=0)
    if len(tall) * len(small) > SEARCHED:
        return None
    if len(small) <= len(tall):
        return any(bool(compare(tall, row).all(axis=1).any()) for row in small)
    return any(bool(compare(row, small).all(axis=1).any()) for row in tall)


def paired_t(x: Array, y: Array) -> Range:
    """Return the range of the paired t of y - x, from the least to the most favourable pairing.

    The means are fixed; only the sum of products is free. For sorted columns it is largest in
    the same order and smallest in the opposite one. If there are too many pairs of data sets
    to search, Cauchy and Schwarz bound it.
    """
    n = x.shape[1]
    sums = np.unique(x.sum(axis=1)), np.unique(y.sum(axis=1))
    squares = [np.unique((c.astype(np.int64) ** 2).sum(axis=1)) for c in (x, y)]
    if any(len(part) > 1 for part in sums):
        raise ValueError("the mean is not fixed: bounds on t need one sum a column")
    sx, sy = (int(part[0]) for part in sums)
    difference = sy - sx
    sharp = len(x) * len(y) <= SEARCHED
    edges = []
    for favourable in (False, True):
        pick = max if favourable == (difference >= 0) else min
        if sharp:
            found = _extreme(x, y, same=favourable)
        else:
            vx, vy = int(squares[0][-1]) - sx**2 / n, int(squares[1][-1]) - sy**2 / n
            found = [vx + vy - (2 if favourable else -2) * sqrt(vx * vy) + difference**2 / n]
        ts = []
        for squared in found:
            variance = max(squared - difference**2 / n, 0.0) / (n - 1)
            ts.append(difference / sqrt(n * variance) if variance else float("inf"))
        edges.append(pick(ts))
    return Range(min(edges), max(edges), sharp)


def _extreme(x: Array, y: Array, *, same: bool) -> list[float]:
    """Return the extreme sum of squared differences: smallest for the `same` order."""
    a, b = x.astype(np.float64), y.astype(np.float64)
    if not same:
        b = b[:, ::-1]
    # Whole numbers below 2^53: products and sums are exact in floating point.
    ends = (b**2).sum(axis=1)
    best = float("inf") if same else -float("inf")
    for first in range(0, len(a), BLOCK):
        part = a[first : first + BLOCK]
        squared = (part**2).sum(axis=1)[:, None] + ends - 2 * (part @ b.T)
        best = min(best, float(squared.min())) if same else max(best, float(squared.max()))
    return [best]


def log_mean(x: Array) -> Range:
    """Return the range of a column's mean natural logarithm (ratings above 0)."""
    means = np.log(x).mean(axis=1)
    return Range(float(means.min()), float(means.max()), sharp=True)


def slope(means: list[Range], log_amplitude: list[float]) -> Range:
    """Return the range of the least-squares slope of log means on log amplitudes."""
    centred = np.array(log_amplitude) - np.mean(log_amplitude)
    share = centred / (centred**2).sum()
    low = sum(s * (m.low if s > 0 else m.high) for s, m in zip(share, means, strict=True))
    high = sum(s * (m.high if s > 0 else m.low) for s, m in zip(share, means, strict=True))
    return Range(float(low), float(high), sharp=all(m.sharp for m in means))


def repeated_measures_f(columns: list[Array]) -> float:
    """Return a lower bound on the repeated-measures F of n participants by k columns.

    Sums of squares between columns and in total follow from the table; what participants
    differ by is taken out of the error. It is least when their totals are as equal as whole
    numbers can be, and then F is least, too.
    """
    k, n = len(columns), columns[0].shape[1]
    sums = [int(c[0].sum()) for c in columns]
    squares = sum(int((c.astype(np.int64) ** 2).sum(axis=1).max()) for c in columns)
    grand = sum(sums)
    between = sum(s * s for s in sums) / n - grand**2 / (n * k)
    low, rest = divmod(grand, n)
    participants = ((n - rest) * low**2 + rest * (low + 1) ** 2) / k - grand**2 / (n * k)
    error = squares - grand**2 / (n * k) - between - participants
    return float(between / (k - 1) / (error / ((k - 1) * (n - 1))))
