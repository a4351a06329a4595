"""Group the possible data sets of a column by their sum and sum of squares.

Possible sums and sums of squares follow directly from the published numbers. To list or sample data
sets, they must be counted first, which can be slow. If sums and sums of squares are sufficient, set
`sums_first`: data sets are then not counted, and single data sets are searched for when needed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slipscale.analysis.reconstruction.counts.listing import LISTED
from slipscale.analysis.reconstruction.counts.problem import seconds_to_count
from slipscale.analysis.reconstruction.counts.state_table import Array
from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.data_sets.witness import witness_of

# If counting data sets would take longer than this, `ColumnRows.quickest` sets `sums_first`.
QUICK_S = 0.25
# Number of data sets drawn if there are too many to list.
DRAWN = 2000


@dataclass(frozen=True)
class ColumnRows:
    """The data sets of a column, grouped by sum and sum of squares.

    Parameters
    ----------
    solutions : Solutions
        Solutions of the column.
    sums_first : bool
        Whether to derive sums and sums of squares from the published numbers, without counting
        data sets. Some of these sums may not occur in any data set.
    """

    solutions: Solutions
    sums_first: bool = False

    @classmethod
    def quickest(cls, solutions: Solutions) -> ColumnRows:
        """Return the groups of a column, with `sums_first` set unless counting is quick."""
        return cls(
            solutions,
            sums_first=bool(solutions.refused) or seconds_to_count(solutions.problems) > QUICK_S,
        )

    @property
    def n(self) -> int:
        """Number of ratings in the column."""
        return self.solutions.column.n

    @cached_property
    def moments(self) -> tuple[tuple[int, int], ...]:
        """Pairs (sum, sum of squares) of the ratings, in steps above the scale minimum."""
        if self.sums_first:
            return tuple((m.total, m.squares) for m in self.solutions.targets.moments)
        return self.solutions.attained[0]

    @cached_property
    def listed(self) -> Array | None:
        """All data sets, one sorted row per data set, or None if they cannot be listed."""
        found = self.solutions
        if self.sums_first or found.not_drawn or found.multisets > LISTED:
            return None
        return found.listed

    @cached_property
    def _groups(self) -> dict[tuple[int, int], Array]:
        rows = self.listed if self.listed is not None else self._drawn
        pairs = np.stack([rows.sum(axis=1), (rows.astype(np.int64) ** 2).sum(axis=1)], axis=1)
        kinds, which = np.unique(pairs, axis=0, return_inverse=True)
        return {
            (int(s), int(q)): rows[which.ravel() == place] for place, (s, q) in enumerate(kinds)
        }

    @cached_property
    def _drawn(self) -> Array:
        if self.sums_first or self.solutions.not_drawn:
            return np.zeros((0, self.n), dtype=np.int32)
        return Sampler(self.solutions).draw(DRAWN, np.random.default_rng(1))

    def rows(self, place: int) -> Array:
        """Return the listed or drawn data sets with the sum and sum of squares at index `place`."""
        return self._groups.get(self.moments[place], np.zeros((0, self.n), dtype=np.int32))

    def some(self, place: int) -> Array:
        """Return data sets with the sum and sum of squares at index `place`.

        If no such data set is known, a search tries to find one.
        """
        rows = self.rows(place)
        if len(rows) or self.listed is not None:
            return rows
        found = witness_of(self.solutions.column, self.solutions.targets, self.moments[place])
        return np.array([found], dtype=np.int32) if found else rows
