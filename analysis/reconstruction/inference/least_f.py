"""The least repeated-measures F over all data sets and pairings, and a table that attains it.

Sums of squares between columns and in total follow from the table; what participants differ by is
taken out of the error. It is least when their totals are as equal as whole numbers can be, and
then F is least, too. Only sums and sums of squares are needed, so it holds for columns of any
size. Whether some table has totals that equal is found out by a search.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import inf, prod
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.inference.bounds import Range, Table, as_table
from slipscale.analysis.reconstruction.inference.pairing import searched

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.data_sets.sampling import Sampler

    Moments = tuple[tuple[int, int], ...]

# Combinations of sums that are taken in turn; of more, F is not bounded.
COMBINATIONS = 100_000
# Data sets of a column that are drawn for the search, tables in each of its rounds, and its seed.
DRAWN = 2000
TABLES = 2000
ROUNDS = 20
SEED = 1


@dataclass(frozen=True)
class _Case:
    """One sum and sum of squares a column, and the least F beside them."""

    f: float
    moments: Moments


def least_f(moments: Sequence[Moments], n: int) -> float | None:
    """Return a lower bound on F from sums and sums of squares; None: too many combinations.

    Parameters
    ----------
    moments : sequence of tuple of (int, int)
        The sums and sums of squares that each column may have.
    n : int
        Participants.
    """
    found = _least(moments, n)
    return found.f if found else None


def attained_f(columns: Sequence[Sampler]) -> Range | None:
    """Return the range of F with a table that attains the lower end, if a search finds one.

    From above, F is not bounded: the error may vanish.
    """
    moments = [column.solutions.attained[0] for column in columns]
    case = _least(moments, columns[0].solutions.column.n)
    return Range(case.f, inf, _table(columns, case)) if case else None


def _least(moments: Sequence[Moments], n: int) -> _Case | None:
    """Return the least case; where a rounded mean leaves sums open, over all of them."""
    most = [_most_squares(column) for column in moments]
    if prod(map(len, most)) > COMBINATIONS:
        return None
    cases = (_Case(_f_of(pairs, n), pairs) for pairs in product(*(m.items() for m in most)))
    return min(cases, key=lambda case: case.f)


def _most_squares(moments: Moments) -> dict[int, int]:
    """Return the largest sum of squares beside each sum: it leaves the largest error."""
    return {total: max(q for s, q in moments if s == total) for total, _ in moments}


def _f_of(moments: Moments, n: int) -> float:
    k = len(moments)
    sums, squares = [s for s, _ in moments], sum(q for _, q in moments)
    grand = sum(sums)
    low, rest = divmod(grand, n)
    # Times n k, in whole numbers, so that nothing is lost where little error is left.
    between = k * sum(s * s for s in sums) - grand**2
    participants = n * ((n - rest) * low**2 + rest * (low + 1) ** 2) - grand**2
    error = n * k * squares - grand**2 - between - participants
    return (n - 1) * between / error if error > 0 else inf


def _table(columns: Sequence[Sampler], case: _Case) -> Table:
    """Return a table whose participants have totals as equal as can be; empty if none is found."""
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
