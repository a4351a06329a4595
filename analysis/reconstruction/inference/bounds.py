"""Compute bounds on statistics of two or more columns, valid for every data set and pairing.

A published table does not state which ratings in different columns are from the same participant,
so bounds must hold for every pairing of ratings. A sharp bound is attained by data sets and a
pairing that are returned with the bound. Other bounds are valid, but may be wider than necessary.
For the paired t, see `extreme_t`. For the repeated-measures F, see `repeated_measures_f`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from slipscale.analysis.reconstruction.counts.state_table import Array

# Ratings in steps above the scale minimum: one row per column, with the same order of participants.
Table = tuple[tuple[int, ...], ...]

# Maximum number of pairs of data sets that are searched exhaustively.
SEARCHED = 60_000_000
# Number of rows that are tried first because their sums are the largest or smallest.
CANDIDATES = 200


@dataclass(frozen=True)
class Range:
    """The smallest and largest value of a statistic over all data sets and pairings.

    Parameters
    ----------
    low, high : float
        Bounds on the value.
    at_low, at_high : tuple of tuple of int
        Tables of ratings that attain the bounds, with one row per column, in steps above the scale
        minimum. Empty if no table is known.
    """

    low: float
    high: float
    at_low: Table = ()
    at_high: Table = ()

    @property
    def sharp(self) -> bool:
        """Whether tables are known for both bounds."""
        return bool(self.at_low and self.at_high)


def as_table(*rows: Array) -> Table:
    """Convert rows of ratings to a table of Python integers."""
    return tuple(tuple(int(v) for v in row) for row in rows)


def larger(x: Array, y: Array) -> Range:
    """Return the smallest and largest possible number of participants with y > x.

    Parameters
    ----------
    x, y : ndarray of int, shapes (p, n) and (q, n)
        All data sets of two columns, one sorted row per data set.

    Notes
    -----
    At least r participants can have y > x if and only if the r largest y exceed the r smallest x in
    sorted order. The lower bound follows in the same way from the participants with y <= x.
    """
    n = x.shape[1]
    most, at_most = _largest(y, x, np.greater)
    not_above, at_least = _largest(x, y, np.greater_equal)
    return Range(n - not_above, most, at_least, at_most[::-1])


def _largest(upper: Array, lower: Array, compare: np.ufunc) -> tuple[int, Table]:
    """Return the largest r such that the r largest of `upper` can exceed the r smallest of `lower`.

    Also returns a row of `upper` and a row of `lower` that attain this r. If no rows are returned,
    r is only an upper bound.
    """
    n = upper.shape[1]
    shown, rows = 0, (upper[0], lower[0])
    for r in range(1, n + 1):
        answer = _beats(upper, lower, r, compare)
        if answer is False:
            break
        if answer is not None:
            shown, rows = r, answer
    else:
        r = n + 1
    tall = np.concatenate([rows[0][n - shown :], rows[0][: n - shown]])
    return r - 1, as_table(tall, rows[1]) if shown == r - 1 else ()


def _beats(
    upper: Array, lower: Array, r: int, compare: np.ufunc
) -> tuple[Array, Array] | Literal[False] | None:
    """Find a row of `upper` whose r largest values exceed the r smallest of a row of `lower`.

    Returns both rows, False if no such rows exist, or None if there are too many to search.
    """
    tall, small = upper[:, upper.shape[1] - r :], lower[:, :r]
    # Rows with extreme sums are tried first, because they usually are a solution.
    first, second = _largest_sums(tall), _largest_sums(-small)
    won = compare(tall[first][:, None], small[second][None]).all(axis=2)
    if won.any():
        i, j = np.unravel_index(won.argmax(), won.shape)
        return upper[first[i]], lower[second[j]]
    # A row of `tall` that does not exceed the element-wise minimum of `small` exceeds no row of
    # `small`, and vice versa.
    rows = 0, 0
    while rows != (len(tall), len(small)):
        rows = len(tall), len(small)
        keep = compare(tall, small.min(axis=0)).all(axis=1)
        tall, upper = tall[keep], upper[keep]
        if not len(tall):
            return False
        keep = compare(tall.max(axis=0), small).all(axis=1)
        small, lower = small[keep], lower[keep]
        if not len(small):
            return False
    if len(tall) * len(small) > SEARCHED:
        return None
    for row, whole in zip(small, lower, strict=True):
        won = compare(tall, row).all(axis=1)
        if won.any():
            return upper[won.argmax()], whole
    return False


def _largest_sums(rows: Array) -> Array:
    sums = rows.sum(axis=1)
    few = min(CANDIDATES, len(sums))
    found: Array = np.argpartition(sums, -few)[-few:]
    return found


def log_mean(x: Array) -> Array:
    """Return the mean natural logarithm of each row. All ratings must be above 0."""
    found: Array = np.log(x).mean(axis=1)
    return found


def of_rows(values: Array, rows: Array) -> Range:
    """Return the smallest and largest value, with the rows in which they occur."""
    least, most = int(values.argmin()), int(values.argmax())
    at_ends = as_table(rows[least]), as_table(rows[most])
    return Range(float(values[least]), float(values[most]), *at_ends)


def slope(means: list[Range], log_amplitude: list[float]) -> Range:
    """Return the range of the least-squares slope of log means against log amplitudes."""
    centred = np.array(log_amplitude) - np.mean(log_amplitude)
    share = centred / (centred**2).sum()
    pairs = list(zip(share, means, strict=True))
    return Range(
        float(sum(s * (m.low if s > 0 else m.high) for s, m in pairs)),
        float(sum(s * (m.high if s > 0 else m.low) for s, m in pairs)),
        tuple(row for s, m in pairs for row in (m.at_low if s > 0 else m.at_high)),
        tuple(row for s, m in pairs for row in (m.at_high if s > 0 else m.at_low)),
    )
