"""List all data sets consistent with a column, one per row."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from slipscale.analysis.reconstruction.counts.counting import largest_possible
from slipscale.analysis.reconstruction.counts.problem import Problem, require_memory
from slipscale.analysis.reconstruction.counts.residues import WORD, moduli_above
from slipscale.analysis.reconstruction.counts.state_table import Array
from slipscale.analysis.reconstruction.counts.unranking import Ranking

# Maximum number of multisets to list, and number of multisets per batch.
LISTED = 2**20
CHUNK = 2**18


def rankings(tasks: list[Problem], measure: str, memory_gib: float) -> list[Ranking]:
    """Return one `Ranking` of solutions per problem.

    Raises
    ------
    UserError
        If the state tables need more than `memory_gib`.
    """
    moduli = moduli_above(largest_possible(tasks, measure))
    require_memory(tasks, memory_gib, len(moduli))
    return [Ranking(task, measure, moduli) for task in tasks]


def multisets(tasks: list[Problem], n: int, memory_gib: float) -> Array:
    """Return all multisets of n ratings, one per row.

    Ratings are sorted within a row, and are given as numbers of scale steps above the minimum of
    the scale.
    """
    blocks = [
        block for ranking in rankings(tasks, "multisets", memory_gib) for block in _blocks(ranking)
    ]
    return np.concatenate([np.zeros((0, n), dtype=np.int32), *blocks])


def _blocks(ranking: Ranking) -> Iterator[Array]:
    for first in range(0, ranking.total, CHUNK):
        ranks = np.arange(first, min(first + CHUNK, ranking.total), dtype=np.uint64)
        yield ranking.solutions(ranks)


def arrangements(rows: Array, total: int | None = None) -> Array:
    """Return the number of orderings of each sorted row: n! / (c1! c2! ...).

    Multiplications and divisions alternate, so that every intermediate result is a whole number.
    Intermediate results are at most n times `total`. Python integers are used unless this bound
    fits in 64 bits.
    """
    n = rows.shape[1]
    kind = np.dtype(np.uint64 if total is not None and n * total < WORD else object)
    ways, run = np.ones(len(rows), dtype=kind), np.ones(len(rows), dtype=np.int64)
    for i in range(1, n):
        run = np.where(rows[:, i] == rows[:, i - 1], run + 1, 1)
        ways = ways * np.array(i + 1, dtype=kind) // run.astype(kind)
    return ways
