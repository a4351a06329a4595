"""Find the smallest and largest paired t over all data sets and pairings.

For fixed sums and sums of squares, t depends only on the sum of products. The sum of products is
largest if both columns are sorted in the same order, and smallest if they are sorted in opposite
order. If the columns have many possible data sets, a nearest-neighbour search finds the pair with
the largest sum of products, because this is the pair with the smallest distance between the
standardised data sets. If data sets are not listed, bounds on t follow from sums and sums of
squares by the Cauchy-Schwarz inequality.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import product
from math import copysign, inf, sqrt

import numpy as np

from slipscale.analysis.reconstruction.counts.state_table import Array
from slipscale.analysis.reconstruction.inference.bounds import SEARCHED, Range, Table, as_table

# Maximum number of pairs of data sets for a nearest-neighbour search. The largest case in Table III
# has 4e10 pairs and takes seconds.
COMPARED = 100_000_000_000
BLOCK = 2048


@dataclass(frozen=True)
class _Rows:
    """Data sets of one column that have the same sum and the same sum of squares."""

    rows: Array
    total: int
    squares: int

    @property
    def root(self) -> float:
        """The value of sqrt(n * sum of squared deviations)."""
        return sqrt(self.rows.shape[1] * self.squares - self.total**2)


def paired_t(x: Array, y: Array) -> Range:
    """Return the range of the paired t of y - x over all data sets and pairings.

    All combinations of sums and sums of squares are examined, except those that cannot widen the
    range because of the Cauchy-Schwarz inequality. If the lists are too long for a
    nearest-neighbour search, the Cauchy-Schwarz bounds on t are returned without tables.

    Parameters
    ----------
    x, y : ndarray of int, shapes (p, n) and (q, n)
        All data sets of two columns, one sorted row per data set.
    """
    return _extremes(x, y, lambda t: t)


def squared_t(x: Array, y: Array) -> Range:
    """Return the range of the square of the paired t, which is F; see `paired_t`."""
    found = _extremes(x, y, abs)
    return replace(found, low=found.low**2, high=found.high**2)


def _extremes(x: Array, y: Array, form: Callable[[float], float]) -> Range:
    """Return the range of t or of its absolute value, as ``form`` says."""
    # A range at infinity has tables, too, so the comparison is not with infinity.
    lowest: tuple[float, Table] | None = None
    highest: tuple[float, Table] | None = None
    n = x.shape[1]
    pairs = []
    for a, b in product(_by_moments(x), _by_moments(y)):
        cauchy = _by_cauchy(a, b, n)
        ends = sorted((form(cauchy.low), form(cauchy.high)))
        # The larger |t| is that of the same order, which is the smaller t if the sums fall.
        pairs.append((a, b, ends, form(b.total - a.total) >= 0))
    for a, b, (least, most), rises in sorted(pairs, key=lambda pair: pair[2][0] - pair[2][1]):
        searched = len(a.rows) * len(b.rows) <= COMPARED
        if highest is None or most > highest[0]:
            value, at = _t(a, b, same=rises) if searched else (most, ())
            if highest is None or form(value) > highest[0]:
                highest = form(value), at
        if lowest is None or least < lowest[0]:
            value, at = _t(a, b, same=not rises) if searched else (least, ())
            if lowest is None or form(value) < lowest[0]:
                lowest = form(value), at
    (low, at_low), (high, at_high) = lowest or (inf, ()), highest or (-inf, ())
    return Range(low, high, at_low, at_high)


def _by_moments(rows: Array) -> list[_Rows]:
    moments = np.stack([rows.sum(axis=1), (rows.astype(np.int64) ** 2).sum(axis=1)], axis=1)
    found, which = np.unique(moments, axis=0, return_inverse=True)
    return [
        _Rows(rows[which.ravel() == place], int(total), int(squares))
        for place, (total, squares) in enumerate(found)
    ]


def _by_cauchy(a: _Rows, b: _Rows, n: int) -> Range:
    return _t_of_roots(b.total - a.total, n, (abs(a.root - b.root), a.root + b.root))


def t_of_moments(x: Iterable[tuple[int, int]], y: Iterable[tuple[int, int]], n: int) -> Range:
    """Return bounds on the paired t of y - x, using only sums and sums of squares.

    Parameters
    ----------
    x, y : iterable of (int, int)
        Possible pairs of sum and sum of squares of each column.
    n : int
        Number of participants.
    """
    low, high = inf, -inf
    for (a, roots_a), (b, roots_b) in product(_roots(x, n), _roots(y, n)):
        # The roots lie between the roots for the smallest and the largest sum of squares.
        apart = max(roots_a[0] - roots_b[1], roots_b[0] - roots_a[1], 0.0)
        found = _t_of_roots(b - a, n, (apart, roots_a[1] + roots_b[1]))
        low, high = min(low, found.low), max(high, found.high)
    return Range(low, high)


def _roots(moments: Iterable[tuple[int, int]], n: int) -> list[tuple[int, tuple[float, float]]]:
    """Return each sum with the smallest and largest sqrt(n * sum of squared deviations)."""
    ends: dict[int, tuple[float, float]] = {}
    for total, squares in moments:
        root = sqrt(n * squares - total**2)
        least, most = ends.get(total, (root, root))
        ends[total] = (min(least, root), max(most, root))
    return list(ends.items())


def _t_of_roots(difference: int, n: int, roots: tuple[float, float]) -> Range:
    # The interval is widened so that rounding errors exclude nothing.
    ends = (roots[0] * (1 - 1e-12), roots[1] * (1 + 1e-12))
    ts = [_t_of_scatter(difference, n, scatter**2) for scatter in ends]
    return Range(min(ts), max(ts))


def _t_of_scatter(difference: int, n: int, scatter: float) -> float:
    """Compute t from the sum of n differences and n times their sum of squared deviations."""
    if not difference:
        return 0.0
    return difference * sqrt((n - 1) / scatter) if scatter > 0 else copysign(inf, difference)


def _t(a: _Rows, b: _Rows, *, same: bool) -> tuple[float, Table]:
    """Return t for the rows with the largest (`same`) or smallest sum of products, and the rows."""
    difference, n = b.total - a.total, a.rows.shape[1]
    y = b.rows if same else b.rows[:, ::-1]
    # If the sums are equal, t is 0 for all rows.
    rows = most_alike_rows(a.rows, y, same=same) if difference else (a.rows[0], y[0])
    squared = sum((int(v) - int(u)) ** 2 for u, v in zip(*rows, strict=True))
    return _t_of_scatter(difference, n, n * squared - difference**2), as_table(*rows)


def most_alike_rows(x: Array, y: Array, *, same: bool) -> tuple[Array, Array]:
    """Return the row of `x` and the row of `y` with the largest or smallest sum of products.

    The sum of products is maximised if `same` is True, and minimised otherwise. All rows of `x`
    must have the same sum and the same sum of squares, and so must all rows of `y`.
    """
    if len(x) * len(y) <= SEARCHED:
        # Whole numbers below 2^53 are exact in floating point.
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
    from scipy.spatial import cKDTree

    tree, best, at = cKDTree(many), inf, (0, 0)
    for first in range(0, len(few), BLOCK):
        # Using all cores does not change the result, because each point is searched independently.
        distances, places = tree.query(
            few[first : first + BLOCK], distance_upper_bound=best, workers=-1
        )
        nearest = int(distances.argmin())
        if distances[nearest] < best:
            best, at = float(distances[nearest]), (first + nearest, int(places[nearest]))
    return at
