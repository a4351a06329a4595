"""List all data sets behind a column, one per row, if there are not too many."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.counts.counting import largest_possible
from slipscale.analysis.reconstruction.counts.problem import require_memory
from slipscale.analysis.reconstruction.counts.residues import WORD, moduli_above
from slipscale.analysis.reconstruction.counts.unranking import Ranking

if TYPE_CHECKING:
    from collections.abc import Iterator

    from slipscale.analysis.reconstruction.counts.problem import Problem
    from slipscale.analysis.reconstruction.counts.state_table import Array

# Maximum number of multisets to list, and number processed together.
LISTED = 2**20
CHUNK = 2**18


def rankings(tasks: list[Problem], measure: str, memory_gib: float) -> list[Ranking]:
    """Return the solutions of every problem in a fixed order.

    Raises
    ------
    UserError
        If their tables need more than `memory_gib`.
    """
    moduli = moduli_above(largest_possible(tasks, measure))
    require_memory(tasks, memory_gib, len(moduli))
    return [Ranking(task, measure, moduli) for task in tasks]


def multisets(tasks: list[Problem], n: int, memory_gib: float) -> Array:
    """Return every multiset of n values, sorted, in steps above the scale's minimum."""
    blocks = [
        block for ranking in rankings(tasks, "multisets", memory_gib) for block in _blocks(ranking)
    ]
    return np.concatenate([np.zeros((0, n), dtype=np.int32), *blocks])


def _blocks(ranking: Ranking) -> Iterator[Array]:
    """Yield every solution of a ranking."""
    for first in range(0, ranking.total, CHUNK):
        ranks = np.arange(first, min(first + CHUNK, ranking.total), dtype=np.uint64)
        yield ranking.solutions(ranks)


def arrangements(rows: Array, total: int | None = None) -> Array:
    """Return the number of orderings of each sorted row: n! / (c1! c2! ...).

    Computed one value at a time, so every quotient is a whole number. Uses Python integers unless
    n times `total`, which bounds all intermediate results, fits in a machine word.
    """
    n = rows.shape[1]
    kind = np.dtype(np.uint64 if total is not None and n * total < WORD else object)
    ways, run = np.ones(len(rows), dtype=kind), np.ones(len(rows), dtype=np.int64)
    for i in range(1, n):
        run = np.where(rows[:, i] == rows[:, i - 1], run + 1, 1)
        ways = ways * np.array(i + 1, dtype=kind) // run.astype(kind)
    return ways
