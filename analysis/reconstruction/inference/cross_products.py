"""Bound the sum of cross products, which is unknown if the pairing of ratings is unknown.

For k columns of the same n participants, the sum of cross products is the sum over all pairs of
columns and all participants of the product of two ratings, in steps above the scale minimum.
Together with the sums and sums of squares, it determines the paired t, Pearson's r and the
repeated-measures F. For each pair of columns, the sum of products is largest if both are sorted in
the same order, and smallest if they are sorted in opposite orders (rearrangement inequality). If
the data sets are not listed, bounds follow from the Cauchy-Schwarz inequality. To find a pairing
with a given sum of cross products, ratings are swapped between participants and, for small n, all
pairings are tried.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, permutations, product
from math import factorial, prod
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.inference.bounds import SEARCHED

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.inference.column_rows import ColumnRows

# If there are at most `CHOICES` combinations of a sum and a sum of squares per column, all are
# examined, and otherwise a random selection of `SOME`.
CHOICES = 3_000_000
SOME = 300_000
# Numbers of choices searched for an example (most promising, and random), and number of tables per
# choice.
SOUGHT = 40
TABLES = 12
# Maximum number of pairings for an exhaustive search. If there are more pairings, a test may remain
# undecided.
PAIRINGS = 2_000_000
# Maximum number of participants for which all orders of a column are listed.
ORDERED = 8


@dataclass(frozen=True)
class Choices:
    """Combinations of one sum and one sum of squares per column, with the bounds that they imply.

    Parameters
    ----------
    places : ndarray of int, shape (choices, columns)
        For each column, the index of its sum and sum of squares in `ColumnRows.moments`.
    sums, squares : ndarray of int, shape (choices, columns)
        Sums and sums of squares, in steps above the scale minimum.
    least, most : ndarray of int, shape (choices,)
        Bounds on the sum of cross products over all pairings.
    complete : bool
        Whether all combinations are included. If False, only a random selection is included.
    n : int
        Number of participants.
    """

    places: Array
    sums: Array
    squares: Array
    least: Array
    most: Array
    complete: bool
    n: int

    def error(self, cross: Array) -> Array:
        """Return n k times the error sum of squares for given sums of cross products."""
        k = self.sums.shape[1]
        squares = self.squares.sum(axis=1)
        found: Array = self.n * (k - 1) * squares - self.between - 2 * self.n * cross
        return found

    @property
    def between(self) -> Array:
        """The sum of squares between columns, multiplied by n k."""
        k = self.sums.shape[1]
        found: Array = k * (self.sums**2).sum(axis=1) - self.sums.sum(axis=1) ** 2
        return found


def every_place(sizes: Sequence[int]) -> tuple[Array, bool]:
    """Return combinations of indices, one per column, and whether they are complete."""
    if prod(sizes) <= CHOICES:
        return np.stack([m.ravel() for m in np.indices(sizes)], axis=1), True
    generator = np.random.default_rng(3)
    return np.stack([generator.integers(size, size=SOME) for size in sizes], axis=1), False


def choices(columns: Sequence[ColumnRows]) -> Choices:
    """Return combinations of sums and sums of squares, with bounds on the sum of cross products.

    If there are too many combinations, a random selection is returned.
    """
    n, k = columns[0].n, len(columns)
    places, complete = every_place([len(column.moments) for column in columns])
    moments = [np.array(column.moments, dtype=np.int64).reshape(-1, 2) for column in columns]
    sums, squares = (
        np.stack([moments[j][places[:, j], part] for j in range(k)], axis=1) for part in (0, 1)
    )
    least, most = np.zeros(len(places), np.int64), np.zeros(len(places), np.int64)
    for i, j in combinations(range(k), 2):
        low, high = _products(columns[i], columns[j], places[:, [i, j]])
        least += low
        most += high
    # Participants' totals are whole numbers, so that they cannot always be equal.
    grand = sums.sum(axis=1)
    low, rest = np.divmod(grand, n)
    equal = (n - rest) * low**2 + rest * (low + 1) ** 2
    least = np.maximum(least, -((squares.sum(axis=1) - equal) // 2))
    return Choices(places, sums, squares, least, most, complete, n)


def _products(a: ColumnRows, b: ColumnRows, places: Array) -> tuple[Array, Array]:
    """Return bounds on the sum of products of two columns, for each row of `places`."""
    if a.listed is not None and b.listed is not None and len(a.listed) * len(b.listed) <= SEARCHED:
        pairs, at = np.unique(places, axis=0, return_inverse=True)
        low, high = np.empty(len(pairs), np.int64), np.empty(len(pairs), np.int64)
        for pair, (i, j) in enumerate(pairs.tolist()):
            x, y = (rows.astype(np.float64) for rows in (a.rows(i), b.rows(j)))
            # Whole numbers below 2^53 are exact in floating point.
            high[pair] = int((x @ y.T).max())
            low[pair] = int((x @ y[:, ::-1].T).min())
        at = at.reshape(-1)  # only NumPy 2.0 returns a two-dimensional array
        return low[at], high[at]
    one, two = (
        np.array(column.moments, dtype=np.int64)[at]
        for column, at in zip((a, b), places.T, strict=True)
    )
    n = a.n
    spread = [np.sqrt(np.maximum(n * m[:, 1] - m[:, 0] ** 2, 0).astype(float)) for m in (one, two)]
    reach = spread[0] * spread[1] * (1 + 1e-12) + 1e-6
    middle = one[:, 0] * two[:, 0]
    return (
        np.ceil((middle - reach) / n).astype(np.int64),
        np.floor((middle + reach) / n).astype(np.int64),
    )


def example(
    columns: Sequence[ColumnRows],
    found: Choices,
    wanted: tuple[Array, Array],
    generator: np.random.Generator,
) -> tuple[Array, ...]:
    """Return ratings with an acceptable sum of cross products, or () if the search fails.

    Parameters
    ----------
    columns : sequence of ColumnRows
    found : Choices
    wanted : tuple of ndarray of int
        Smallest and largest acceptable sum of cross products for each combination in `found`. A
        combination is skipped if its smallest value exceeds its largest value.
    generator : numpy.random.Generator
        Random generator for selecting data sets and initial pairings.
    """
    width = wanted[1] - wanted[0]
    usable = np.flatnonzero(width >= 0)
    # Intermediate sums of cross products are the most likely to occur.
    margin = np.minimum(wanted[1] - found.least, found.most - wanted[0])[usable]
    by_margin = usable[np.argsort(-margin, kind="stable")]
    some = generator.permutation(usable)[:SOUGHT]
    for choice in dict.fromkeys([*by_margin[:SOUGHT].tolist(), *some.tolist()]):
        low, high = int(wanted[0][choice]), int(wanted[1][choice])
        rows = [c.some(int(p)) for c, p in zip(columns, found.places[choice], strict=True)]
        if not all(len(part) for part in rows):
            continue
        for _ in range(TABLES):
            table = [part[generator.integers(len(part))].astype(np.int64) for part in rows]
            for start in _starts(table, generator):
                if (reached := _exchanged(start, low, high)) is not None:
                    return tuple(reached)
    return ()


def _starts(table: list[Array], generator: np.random.Generator) -> Iterator[Array]:
    """Yield three initial pairings: same order, alternating opposite orders, and random."""
    yield np.array([np.sort(row) for row in table])
    yield np.array([np.sort(row)[:: 1 if place % 2 else -1] for place, row in enumerate(table)])
    yield np.array([generator.permutation(row) for row in table])


def _exchanged(table: Array, low: int, high: int) -> Array | None:
    """Swap ratings within columns until the sum of cross products is from `low` to `high`.

    Each step swaps the two ratings that bring the sum closest to the nearer limit. Returns None if
    the search fails.
    """
    k, n = table.shape
    for _ in range(n * n * k):
        totals = table.sum(axis=0)
        cross = int((totals**2).sum() - (table**2).sum()) // 2
        missing = max(low - cross, 0) or min(high - cross, 0)
        if not missing:
            return table
        best: tuple[int, int, int, int] | None = None
        for j in range(k):
            others = totals - table[j]
            # Swapping ratings i and h changes the sum by (others_i - others_h) (x_h - x_i).
            change = -np.subtract.outer(others, others) * np.subtract.outer(table[j], table[j])
            left = np.abs(missing - change)
            place = int(left.argmin())
            if best is None or left.flat[place] < best[0]:
                best = int(left.flat[place]), j, *divmod(place, n)
        if best is None or best[0] >= abs(missing):
            return None
        _, j, i, h = best
        table[j, i], table[j, h] = table[j, h], table[j, i]
    return None


def every(
    columns: Sequence[ColumnRows], found: Choices, wanted: tuple[Array, Array]
) -> tuple[Array, ...] | None:
    """Try all pairings of all data sets until the sum of cross products is acceptable.

    For `found` and `wanted`, see `example`. Returns () if no pairing gives an acceptable sum, and
    None if there are too many pairings to try.
    """
    n = found.n
    usable = np.flatnonzero(wanted[0] <= wanted[1])
    if n > ORDERED or any(column.listed is None for column in columns):
        return None
    orders = factorial(n) ** (len(columns) - 1)
    number = sum(
        orders
        * prod(len(c.rows(int(p))) for c, p in zip(columns, found.places[choice], strict=True))
        for choice in usable
    )
    if number > PAIRINGS:
        return None
    for choice in usable:
        low, high = wanted[0][choice], wanted[1][choice]
        parts = [c.rows(int(p)) for c, p in zip(columns, found.places[choice], strict=True)]
        for first, *others in product(*parts):
            arranged = [_orders(tuple(row.tolist())) for row in others]
            totals, cross = first[None].astype(np.int64), np.zeros(1, np.int64)
            for rows in arranged:
                cross = (cross[:, None] + totals @ rows.T).ravel()
                totals = (totals[:, None] + rows[None]).reshape(-1, n)
            hit = np.flatnonzero((cross >= low) & (cross <= high))
            if len(hit):
                at = np.unravel_index(int(hit[0]), [len(rows) for rows in arranged])
                return first, *(rows[i] for rows, i in zip(arranged, at, strict=True))
    return ()


@lru_cache(maxsize=512)
def _orders(row: tuple[int, ...]) -> Array:
    return np.array(sorted(set(permutations(row))), dtype=np.int64)
