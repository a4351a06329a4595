"""Find the smallest and largest repeated-measures F over all data sets and pairings.

The published table determines the total sum of squares and the sum of squares between columns. The
sum of squares between participants, which is subtracted from the error, depends on how ratings are
paired. This sum of squares and F are smallest if participants' totals are as equal as whole numbers
allow, and largest if all columns have the same order (see `cross_products`). These bounds on F hold
for columns of any size. A search then tries to find tables whose F equals a bound.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import inf, prod
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.inference.bounds import Range, Table, as_table
from slipscale.analysis.reconstruction.inference.column_rows import ColumnRows
from slipscale.analysis.reconstruction.inference.cross_products import choices
from slipscale.analysis.reconstruction.inference.extreme_t import squared_t
from slipscale.analysis.reconstruction.inference.pairing import searched

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.data_sets.sampling import Sampler

    Moments = tuple[tuple[int, int], ...]

# If there are more combinations of sums, no bounds on F are computed.
COMBINATIONS = 100_000
# Settings of the search: data sets per column, tables per round, rounds, and seed.
DRAWN = 2000
TABLES = 2000
ROUNDS = 20
SEED = 1


@dataclass(frozen=True)
class _Case:
    f: float
    moments: Moments


def least_f(moments: Sequence[Moments], n: int) -> float | None:
    """Return a lower bound on F, or None if there are too many combinations of sums to examine.

    Parameters
    ----------
    moments : sequence of tuple of (int, int)
        Possible pairs of sum and sum of squares of each column.
    n : int
        Number of participants.
    """
    found = _least(moments, n)
    return found.f if found else None


def attained_f(columns: Sequence[Sampler]) -> Range | None:
    """Return the range of F and, if a search finds them, tables with the smallest and largest F.

    For two columns, F is the square of the paired t, whose extremes are attained.
    """
    if len(columns) == 2:  # noqa: PLR2004 - a pair
        return squared_t(*(column.listed for column in columns))
    moments = [column.solutions.attained[0] for column in columns]
    case = _least(moments, columns[0].solutions.column.n)
    if case is None:
        return None
    high, table = greatest_f([ColumnRows(column.solutions) for column in columns])
    return Range(case.f, high, _table(columns, case), table)


def greatest_f(columns: Sequence[ColumnRows]) -> tuple[float, Table]:
    """Return an upper bound on F, and a table that attains it if a search finds one.

    The bound is infinite if the error sum of squares may be zero, or if there are too many
    combinations of sums to examine.
    """
    found = choices(columns)
    if not found.complete:
        return inf, ()
    error = found.error(found.most)
    between = (found.n - 1) * found.between
    # Equal sums give an F of 0, even if the error may be zero.
    undivided = np.where(between > 0, inf, 0.0)
    bound = np.divide(between, error, out=undivided, where=error > 0)
    place = int(bound.argmax())
    return float(bound[place]), _alike(columns, found.places[place], int(found.most[place]))


def _alike(columns: Sequence[ColumnRows], place: Array, most: int) -> Table:
    """Search for sorted data sets with the sum of cross products `most`.

    For each column in turn, the search chooses the data set that correlates best with the sum of
    the other columns.
    """
    rows = [
        column.some(int(at)).astype(np.int64) for column, at in zip(columns, place, strict=True)
    ]
    if not all(map(len, rows)):
        return ()
    generator = np.random.default_rng(SEED)
    for _ in range(ROUNDS):
        table = np.stack([part[generator.integers(len(part))] for part in rows])
        for j in [*range(len(rows))] * 3:
            table[j] = rows[j][(rows[j] @ (table.sum(axis=0) - table[j])).argmax()]
        if int((table.sum(axis=0) ** 2).sum() - (table**2).sum()) // 2 == most:
            return as_table(*table)
    return ()


def _least(moments: Sequence[Moments], n: int) -> _Case | None:
    """Return the sums and sums of squares with the smallest F, or None if there are too many."""
    most = [_most_squares(column) for column in moments]
    if prod(map(len, most)) > COMBINATIONS:
        return None
    cases = (_Case(_f_of(pairs, n), pairs) for pairs in product(*(m.items() for m in most)))
    return min(cases, key=lambda case: case.f)


def _most_squares(moments: Moments) -> dict[int, int]:
    """Return each possible sum with its largest sum of squares, which gives the smallest F."""
    return {total: max(q for s, q in moments if s == total) for total, _ in moments}


def _f_of(moments: Moments, n: int) -> float:
    k = len(moments)
    sums, squares = [s for s, _ in moments], sum(q for _, q in moments)
    grand = sum(sums)
    low, rest = divmod(grand, n)
    # Sums of squares are multiplied by n k, because whole numbers are exact even if the error is
    # small.
    between = k * sum(s * s for s in sums) - grand**2
    participants = n * ((n - rest) * low**2 + rest * (low + 1) ** 2) - grand**2
    error = n * k * squares - grand**2 - between - participants
    return (n - 1) * between / error if error > 0 else inf if between else 0.0


def _table(columns: Sequence[Sampler], case: _Case) -> Table:
    """Search for a table in which participants' totals are as equal as possible."""
    generator = np.random.default_rng(SEED)
    drawn = []
    for column, (total, squares) in zip(columns, case.moments, strict=True):
        rows = column.draw(DRAWN, generator).astype(np.int64)
        fit = rows[(rows.sum(axis=1) == total) & ((rows**2).sum(axis=1) == squares)]
        if not len(fit):
            return ()
        drawn.append(fit)
    for _ in range(ROUNDS):
        chosen = [fit[generator.integers(len(fit), size=TABLES)] for fit in drawn]
        tables = searched(np.stack(chosen, axis=2), _unequal, -1, generator)
        best = tables[_unequal(tables).argmin()]
        totals = best.sum(axis=1)
        if totals.max() - totals.min() <= 1:
            return as_table(*best.T)
    return ()


def _unequal(tables: Array) -> Array:
    found: Array = (tables.sum(axis=2) ** 2).sum(axis=1)
    return found
