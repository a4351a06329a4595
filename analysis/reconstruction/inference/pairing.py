"""Arrange columns into tables of participants, because the pairing of ratings is unknown.

`most_alike` is the most favourable pairing for a test between columns, and is exact. With every
column in the same order, the participants' totals vary the most (rearrangement inequality, pair by
pair), so as much variation as possible is removed from the error. `least_alike` is the opposite.
For two
columns it is exact: one ascending and one descending. For more columns, making the totals as equal
as possible is a hard partition problem. The rearrangement algorithm (Puccetti and Rüschendorf,
2012) is used as a heuristic. It puts each column in turn in the opposite order to the sum of the
others until nothing changes. Statistics that are not a function of the totals are optimised by
exchanges.
"""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from slipscale.analysis.reconstruction.counts.state_table import Array

    Statistic = Callable[[Array], Array]

ROUNDS = 50
# Number of exchanges tried per column and sweep; with up to 17 participants, this covers all of
# them.
EXCHANGES = 136
SWEEPS = 20


def at_random(tables: Array, generator: np.random.Generator) -> Array:
    """Return tables whose columns are shuffled, each independently of the others."""
    return generator.permuted(tables, axis=1)


def most_alike(tables: Array) -> Array:
    """Return tables with every column ascending: participants' totals vary most."""
    return np.sort(tables, axis=1)


def least_alike(tables: Array) -> Array:
    """Return tables with nearly equal participants' totals; heuristic above two columns."""
    found = np.sort(tables, axis=1)
    ascending = found.copy()
    totals = found.sum(axis=2)
    for _ in range(ROUNDS):
        before = (totals**2).sum()
        for j in range(tables.shape[2]):
            others = totals - found[:, :, j]
            place = np.argsort(np.argsort(-others, axis=1, kind="stable"), axis=1)
            found[:, :, j] = np.take_along_axis(ascending[:, :, j], place, axis=1)
            totals = others + found[:, :, j]
        if (totals**2).sum() >= before:
            break
    return found


def searched(
    tables: Array, statistic: Statistic, sign: int, generator: np.random.Generator
) -> Array:
    """Return tables that no exchange of two ratings in a column improves: a heuristic.

    Parameters
    ----------
    tables : ndarray, shape (tables, participants, columns)
        Tables whose columns may be rearranged.
    statistic : callable
        Maps tables to values.
    sign : {+1, -1}
        +1 searches for large values, -1 for small ones.
    generator : numpy.random.Generator
        Draws one of the three starting points and, for more than 17 participants, the exchanges.

    Notes
    -----
    The best of a random pairing, `most_alike` and `least_alike` is improved further, for at most
    `SWEEPS` sweeps.
    """
    starts = [at_random(tables, generator), most_alike(tables), least_alike(tables)]
    values = np.stack([sign * statistic(start) for start in starts])
    first = values.argmax(axis=0)
    rows = np.arange(len(tables))
    found: Array = np.stack(starts)[first, rows]
    best = values[first, rows]
    pairs = list(combinations(range(tables.shape[1]), 2))
    moving = rows
    for _ in range(SWEEPS):
        improved = np.zeros(len(tables), dtype=bool)
        # The first column stays fixed: only the order of the others relative to it matters.
        for j in range(1, tables.shape[2]):
            for a, b in _some(pairs, generator):
                trial = found[moving]
                trial[:, [a, b], j] = trial[:, [b, a], j]
                value = sign * statistic(trial)
                better = value > best[moving]
                taken = moving[better]
                found[taken], best[taken], improved[taken] = trial[better], value[better], True
        moving = np.flatnonzero(improved)
        if not len(moving):
            break
    return found


def _some(pairs: list[tuple[int, int]], generator: np.random.Generator) -> list[tuple[int, int]]:
    if len(pairs) <= EXCHANGES:
        return pairs
    return [pairs[i] for i in generator.choice(len(pairs), EXCHANGES, replace=False)]
