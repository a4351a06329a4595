"""Draw exactly uniform samples from the data sets consistent with a column."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.counts.listing import CHUNK, LISTED, arrangements, rankings
from slipscale.analysis.reconstruction.counts.residues import WORD
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.counts.unranking import Ranking
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions

# Listing all multisets is faster if their number is at most this multiple of the number of samples.
LISTING_PAYS = 4
FEW = 2**12


class Sampler:
    """A sampler that draws each data set consistent with a column with equal probability.

    Parameters
    ----------
    solutions : Solutions
        Solutions of the column.
    measure : {"multisets", "ordered"}
        Whether all multisets of ratings are equally likely ("multisets"), or all assignments of
        ratings to participants ("ordered").

    Raises
    ------
    UserError
        If no data set is consistent with the column, or if the state tables need too much memory.
    """

    def __init__(self, solutions: Solutions, measure: str = "multisets") -> None:
        self.solutions, self.measure = solutions, measure
        if solutions.listed_apart:
            self._ranked: list[Ranking] = []
            ordered = measure == "ordered"
            self.total = solutions.ordered if ordered else solutions.multisets
        else:
            ordered = measure == "ordered"
            tasks = solutions.ordered_problems if ordered else solutions.problems
            self._ranked = rankings(tasks, measure, solutions.memory_gib)
            self.total = sum(ranking.total for ranking in self._ranked)
        if not self.total:
            raise UserError(
                "column '{column}': {reason}",
                column=solutions.column.label,
                reason=solutions.reason,
            )

    @property
    def listed(self) -> Array:
        """All multisets of ratings, one sorted row per multiset.

        Ratings are given as numbers of scale steps above the minimum of the scale.

        Raises
        ------
        UserError
            If there are more than `listing.LISTED` multisets.
        """
        return self.solutions.listed

    @cached_property
    def _ends(self) -> Array:
        return np.cumsum(arrangements(self.listed, self.total))

    def draw(self, number: int, generator: np.random.Generator) -> Array:
        """Return `number` independent random data sets.

        Parameters
        ----------
        number : int
        generator : numpy.random.Generator

        Returns
        -------
        ndarray of int32, shape (number, n)
            Ratings as numbers of scale steps above the minimum of the scale. Rows are sorted if
            `measure` is "multisets", and in participant order if it is "ordered".
        """
        ranks = uniform(self.total, number, generator)
        few = number * LISTING_PAYS < FEW
        many = self.solutions.multisets > min(LISTED, LISTING_PAYS * number)
        if self._ranked and (few or many):
            rows = self._walk(ranks)
        elif self.measure == "multisets":
            rows = self.listed[ranks.astype(np.int64)]
        else:
            rows = self.listed[np.searchsorted(self._ends, ranks, side="right")]
        return generator.permuted(rows, axis=1) if self.measure == "ordered" else rows

    def stream(self, number: int, generator: np.random.Generator) -> Iterator[Array]:
        """Draw `number` data sets as in `draw`, and yield them in blocks."""
        while number > 0:
            block = min(number, CHUNK)
            yield self.draw(block, generator)
            number -= block

    def _walk(self, ranks: Array) -> Array:
        """Return the solutions with the given ranks, which need not be sorted."""
        order = np.argsort(ranks)
        ranks = ranks[order]
        out = np.empty((len(ranks), self.solutions.column.n), dtype=np.int32)
        first = 0
        for ranking in self._ranked:
            last = first + ranking.total
            low, high = (bisect_left(ranks, edge) for edge in (first, last))
            if low < high:
                out[order[low:high]] = ranking.solutions(ranks[low:high] - _like(first, ranks))
            first = last
        return out


def uniform(total: int, number: int, generator: np.random.Generator) -> Array:
    """Return exactly uniform integers from 0 to `total` - 1, which can be arbitrarily large.

    Returns
    -------
    ndarray, shape (number,)
        uint64, or Python integers if `total` exceeds 2^64.
    """
    if total <= WORD:
        return generator.integers(0, total, size=number, dtype=np.uint64)
    bits = (total - 1).bit_length()
    drawn: list[int] = []
    while len(drawn) < number:
        # Rejection sampling, in which fewer than half of the numbers are rejected.
        value = int.from_bytes(generator.bytes((bits + 7) // 8)) >> (-bits % 8)
        if value < total:
            drawn.append(value)
    return np.array(drawn, dtype=object)


def _like(value: int, ranks: Array) -> object:
    return value if ranks.dtype == object else np.uint64(value)
