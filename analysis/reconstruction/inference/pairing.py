"""Arrange columns of ratings into tables of participants, in random or extreme pairings.

The function `most_alike` returns the pairing that is most favourable for detecting differences
between columns. It sorts all columns in the same order, which maximises the variation of
participants' totals (rearrangement inequality for each pair of columns) and so minimises the error.
The function `least_alike` returns the least favourable pairing. For two columns, this is exactly
the pairing of ascending with descending ratings. For more than two columns, making participants'
totals as equal as possible is a hard partition problem. The rearrangement algorithm (Puccetti and
Rüschendorf, 2012) is used as a heuristic: each column in turn is sorted opposite to the sum of the
other columns until nothing changes. The function `searched` optimises other statistics by swapping
ratings.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array

    Statistic = Callable[[Array], Array]

ROUNDS = 50
# Maximum number of pairs of participants whose ratings are swapped on trial, per column and sweep.
# 17 participants form 136 pairs.
EXCHANGES = 136
SWEEPS = 20


def at_random(tables: Array, generator: np.random.Generator) -> Array:
    """Shuffle the columns of each table independently."""
    return generator.permuted(tables, axis=1)


def most_alike(tables: Array) -> Array:
    """Sort all columns in ascending order, so that participants' totals vary most."""
    return np.sort(tables, axis=1)


def least_alike(tables: Array) -> Array:
    """Make participants' totals as equal as possible (approximate for more than two columns)."""
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
    """Optimise a statistic heuristically by swapping ratings within columns.

    Parameters
    ----------
    tables : ndarray, shape (tables, participants, columns)
        Tables to rearrange.
    statistic : callable
        Function that returns one value per table.
    sign : {+1, -1}
        Whether to search for large values (+1) or small values (-1).
    generator : numpy.random.Generator
        Random generator for the random initial pairing. With more than 17 participants, the
        generator also selects the pairs of ratings to swap.

    Notes
    -----
    The search starts from the best of a random pairing, `most_alike` and `least_alike`, and
    ends when no swap improves the statistic, or after `SWEEPS` sweeps.
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
        # Only the order of columns relative to each other matters, so the first column is not
        # changed.
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
