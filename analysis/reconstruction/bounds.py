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
# Of so many the extreme one is found by a search for nearest neighbours.
COMPARED = 10_000_000_000
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

    With sums and sums of squares fixed only the sum of products is free. For sorted columns it
    is largest in the same order and smallest in the opposite one, and over two lists of columns
    it is largest where two standardised columns lie nearest to each other: a search for nearest
    neighbours. Every pair of sums and of sums of squares is taken in turn, but for those that
    cannot widen the range by Cauchy and Schwarz. Lists too long even for that are bounded by
    Cauchy and Schwarz alone.
    """
    low, high, sharp = inf, -inf, True
    for a, b in sorted(product(_by_moments(x), _by_moments(y)), key=_widest):
        outer = _t_by_cauchy(a, b)
        if outer.low >= low and outer.high <= high:
            continue
        if len(a) * len(b) > COMPARED:
            low, high, sharp = min(low, outer.low), max(high, outer.high), False
            continue
        rises = outer.high > 0
        if outer.high > high:
            high = max(high, _t(a, b, same=rises))
        if outer.low < low:
            low = min(low, _t(a, b, same=not rises))
    return Range(low, high, sharp)


def by_sum(rows: Array) -> list[Array]:
    """Return the rows of each sum."""
    sums = rows.sum(axis=1)
    return [rows[sums == total] for total in np.unique(sums)]


def _by_moments(rows: Array) -> list[Array]:
    """Return the rows of each sum and sum of squares."""
    found = []
    for part in by_sum(rows):
        squares = _squares(part)
        found += [part[squares == q] for q in np.unique(squares)]
    return found


def _squares(rows: Array) -> Array:
    found: Array = (rows.astype(np.int64) ** 2).sum(axis=1)
    return found


def _widest(pair: tuple[Array, Array]) -> float:
    """Order pairs so that those that may have the widest range come first."""
    outer = _t_by_cauchy(*pair)
    return outer.low - outer.high


def _t_by_cauchy(x: Array, y: Array) -> Range:
    """Return bounds on t from sums and sums of squares alone."""
    (n, total_x, square_x), (_, total_y, square_y) = _moments(x), _moments(y)
    difference = total_y - total_x
    roots = sqrt(n * square_x - total_x**2), sqrt(n * square_y - total_y**2)
    # Whatever rounding does to the roots, nothing is left out.
    ends = (abs(roots[0] - roots[1]) * (1 - 1e-12), (roots[0] + roots[1]) * (1 + 1e-12))
    ts = [_t_of_scatter(difference, n, scatter**2) for scatter in ends]
    return Range(min(ts), max(ts), sharp=False)


def _moments(rows: Array) -> tuple[int, int, int]:
    """Return n, sum and sum of squares of rows that share them."""
    return rows.shape[1], int(rows[0].sum()), int(_squares(rows[:1])[0])


def _t_of_scatter(difference: int, n: int, scatter: float) -> float:
    """Return t from the sum of n differences and n times their squared deviations."""
    if not difference:
        return 0.0
    return difference * sqrt((n - 1) / scatter) if scatter > 0 else copysign(inf, difference)


def _t(x: Array, y: Array, *, same: bool) -> float:
    """Return the extreme t of rows with one sum and sum of squares each, in one order."""
    n, total_x, _ = _moments(x)
    difference = _moments(y)[1] - total_x
    if not difference:
        return 0.0
    rows = most_alike_rows(x, y if same else y[:, ::-1], same=same)
    squared = sum((int(b) - int(a)) ** 2 for a, b in zip(*rows, strict=True))
    return _t_of_scatter(difference, n, n * squared - difference**2)


def most_alike_rows(x: Array, y: Array, *, same: bool) -> tuple[Array, Array]:
    """Return a row of `x` and one of `y` with the largest (smallest) sum of products.

    Of all pairs of rows, which share their sum and sum of squares in either list.
    """
    if len(x) * len(y) <= SEARCHED:
        # Whole numbers below 2^53: exact in floating point.
        a, b = x.astype(np.float64), y.astype(np.float64).T * (1 if same else -1)
        best, at = -inf, (0, 0)
        for first in range(0, len(a), BLOCK):
            products = a[first : first + BLOCK] @ b
            row, column = divmod(int(products.argmax()), len(y))
            if products[row, column] > best:
                best, at = float(products[row, column]), (first + row, column)
        return x[at[0]], y[at[1]]
    standard_x, standard_y = _standardised(x), _standardised(y) * (1 if same else -1)
    if len(x) > len(y):
        column, row = _nearest(standard_y, standard_x)
    else:
        row, column = _nearest(standard_x, standard_y)
    return x[row], y[column]


def _standardised(rows: Array) -> Array:
    centred = rows - rows.mean(axis=1, keepdims=True)
    lengths = np.sqrt((centred**2).sum(axis=1, keepdims=True))
    found: Array = np.divide(centred, lengths, out=np.zeros_like(centred), where=lengths > 0)
    return found


def _nearest(few: Array, many: Array) -> tuple[int, int]:
    """Return the places of a point of `few` and one of `many` that lie nearest to each other."""
    from scipy.spatial import cKDTree  # noqa: PLC0415 - SciPy takes longer than the counts

    tree, best, at = cKDTree(many), inf, (0, 0)
    for first in range(0, len(few), BLOCK):
        distances, places = tree.query(few[first : first + BLOCK], distance_upper_bound=best)
        nearest = int(distances.argmin())
        if distances[nearest] < best:
            best, at = float(distances[nearest]), (first + nearest, int(places[nearest]))
    return at


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
