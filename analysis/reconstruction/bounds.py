"""What holds in every data set, whoever gave which rating: bounds over two or more columns.

A table never says which rating in one column belongs to which in the next. Every bound here
therefore holds for every pairing. A sharp bound is attained by some pair of data sets that the
table allows; one that is not marked sharp holds all the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import copysign, inf, sqrt
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from analysis.reconstruction.state_table import Array

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


def _beats(tall: Array, small: Array, compare: np.ufunc) -> bool | None:
    """Whether some row of `tall` beats some row of `small` everywhere; None: too many."""
    # Most answers are yes, and rows with extreme sums show it.
    likely = tall[_largest_sums(tall)], small[_largest_sums(-small)]
    if compare(likely[0][:, None], likely[1][None]).all(axis=2).any():
        return True
    # A row that does not beat the best that any other row has beats none of them.
    rows = 0, 0
    while rows != (len(tall), len(small)):
        rows = len(tall), len(small)
        tall = tall[compare(tall, small.min(axis=0)).all(axis=1)]
        if not len(tall):
            return False
        small = small[compare(tall.max(axis=0), small).all(axis=1)]
        if not len(small):
            return False
    if len(tall) * len(small) > SEARCHED:
        return None
    if len(small) <= len(tall):
        return any(bool(compare(tall, row).all(axis=1).any()) for row in small)
    return any(bool(compare(row, small).all(axis=1).any()) for row in tall)


def _largest_sums(rows: Array) -> Array:
    """Return the places of the rows with the largest sums."""
    sums = rows.sum(axis=1)
    few = min(CANDIDATES, len(sums))
    return np.argpartition(sums, -few)[-few:]


def paired_t(x: Array, y: Array) -> Range:
    """Return the range of the paired t of y - x, from the least to the most favourable pairing.

    With the means fixed only the sum of products is free. For sorted columns it is largest in
    the same order and smallest in the opposite one. If there are too many pairs of data sets
    to search, Cauchy and Schwarz bound it. Where a rounded mean leaves the sum open, every
    pair of sums is taken in turn.
    """
    found = [_t_of_sums(a, b) for a, b in product(by_sum(x), by_sum(y))]
    return Range(
        min(part.low for part in found),
        max(part.high for part in found),
        sharp=all(part.sharp for part in found),
    )


def by_sum(rows: Array) -> list[Array]:
    """Return the rows of each sum."""
    sums = rows.sum(axis=1)
    return [rows[sums == total] for total in np.unique(sums)]


def _t_of_sums(x: Array, y: Array) -> Range:
    """Return the range of t for columns with one sum each."""
    n = x.shape[1]
    difference = int(y[0].sum()) - int(x[0].sum())
    if not difference:
        return Range(0.0, 0.0, sharp=True)
    sharp = len(x) * len(y) <= SEARCHED
    if sharp:
        scatters = [n * _extreme(x, y, same=same) - difference**2 for same in (True, False)]
    else:
        (low_x, high_x), (low_y, high_y) = _roots_of_scatter(x), _roots_of_scatter(y)
        scatters = [max(low_x - high_y, low_y - high_x, 0.0) ** 2, (high_x + high_y) ** 2]
    ts = [
        difference * sqrt((n - 1) / scatter) if scatter > 0 else copysign(inf, difference)
        for scatter in scatters
    ]
    return Range(min(ts), max(ts), sharp)


def _roots_of_scatter(rows: Array) -> tuple[float, float]:
    """Return the smallest and largest root of n times the squared deviations, one sum given."""
    n, total = rows.shape[1], int(rows[0].sum())
    squares = (rows.astype(np.int64) ** 2).sum(axis=1)
    return sqrt(n * int(squares.min()) - total**2), sqrt(n * int(squares.max()) - total**2)


def _extreme(x: Array, y: Array, *, same: bool) -> float:
    """Return the extreme sum of squared differences: smallest for the `same` order."""
    a, b = x.astype(np.float64), y.astype(np.float64)
    if not same:
        b = b[:, ::-1]
    # Whole numbers below 2^53: products and sums are exact in floating point.
    ends = (b**2).sum(axis=1)
    best = inf if same else -inf
    for first in range(0, len(a), BLOCK):
        part = a[first : first + BLOCK]
        squared = (part**2).sum(axis=1)[:, None] + ends - 2 * (part @ b.T)
        best = min(best, float(squared.min())) if same else max(best, float(squared.max()))
    return best


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
    numbers can be, and then F is least, too. Where a rounded mean leaves the sum open, every
    combination of sums is taken in turn.
    """
    return min(_f_of_sums(list(parts)) for parts in product(*map(by_sum, columns)))


def _f_of_sums(columns: list[Array]) -> float:
    """Return the lower bound for columns with one sum each."""
    k, n = len(columns), columns[0].shape[1]
    sums = [int(c[0].sum()) for c in columns]
    squares = sum(int((c.astype(np.int64) ** 2).sum(axis=1).max()) for c in columns)
    grand = sum(sums)
    between = sum(s * s for s in sums) / n - grand**2 / (n * k)
    low, rest = divmod(grand, n)
    participants = ((n - rest) * low**2 + rest * (low + 1) ** 2) / k - grand**2 / (n * k)
    error = squares - grand**2 / (n * k) - between - participants
    return float(between / (k - 1) / (error / ((k - 1) * (n - 1)))) if error > 0 else inf
