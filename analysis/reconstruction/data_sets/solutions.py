"""Check, count and list the data sets that are consistent with a published column."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.counts import few_values
from slipscale.analysis.reconstruction.counts.counting import attained, count
from slipscale.analysis.reconstruction.counts.listing import LISTED, arrangements, multisets
from slipscale.analysis.reconstruction.counts.partition import most_parts, partition
from slipscale.analysis.reconstruction.counts.problem import (
    MEMORY_GIB,
    MINUTES,
    Problem,
    problems,
    require_countable,
    require_listable,
    require_memory,
)
from slipscale.analysis.reconstruction.counts.residues import moduli_above
from slipscale.analysis.reconstruction.data_sets.constraints import Targets, plain_sums, targets
from slipscale.analysis.reconstruction.data_sets.witness import witness
from slipscale.analysis.reconstruction.table.quartiles import are_met
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.table.published_table import Column

# Partitions with up to this number of parts are listed under any limits. For others, the cost of a
# count is first estimated from a few parts.
MANY_PARTS = 10_000


@dataclass(frozen=True)
class Solutions:
    """All data sets consistent with `column`.

    Ratings are given as numbers of scale steps above the minimum of the scale.

    Parameters
    ----------
    column : Column
        The published column.
    memory_gib, minutes : float
        Limits on the memory in GiB and on the time in minutes. Computations that would exceed these
        limits raise an error.
    """

    column: Column
    memory_gib: float = MEMORY_GIB
    minutes: float = MINUTES

    @cached_property
    def targets(self) -> Targets:
        """Requirements on the ratings, or the reason why no ratings can meet them."""
        return targets(self.column)

    @cached_property
    def problems(self) -> list[Problem]:
        """Subproblems whose counts of multisets are added, each with one pair of state tables.

        Raises
        ------
        UserError
            If the partition has too many parts to list within the limits.
        """
        return self._problems("multisets", self._parts("multisets"))

    @cached_property
    def ordered_problems(self) -> list[Problem]:
        """Subproblems whose counts of ordered samples are added, as in `problems`."""
        return self._problems("ordered", self.ordered_parts)

    @cached_property
    def ordered_parts(self) -> int:
        """Upper bound on the number of parts of the partition of ordered samples."""
        return self._parts("ordered")

    def _parts(self, measure: str) -> int:
        return sum(most_parts(wish, measure) for wish in self.targets.wanted)

    def _problems(self, measure: str, parts: int) -> list[Problem]:
        if self.targets.refused:
            raise UserError(
                "column '{column}': {reason}", column=self.column.label, reason=self.targets.refused
            )
        wanted = self.targets.wanted
        if parts > max(len(wanted), MANY_PARTS):
            require_listable(parts, self.memory_gib, self.minutes)
        return problems(partition(wanted, measure))

    @cached_property
    def multisets(self) -> int:
        """Number of data sets, ignoring the order of participants."""
        if self.listed_apart:
            return len(self.listed)
        return self._unfiltered

    @cached_property
    def _unfiltered(self) -> int:
        """Number of data sets, ignoring published quartiles and the order of participants."""
        if self._of_few_values is not None:
            return self._of_few_values
        return count(self.problems, "multisets", self.memory_gib, self.minutes)

    @cached_property
    def _of_few_values(self) -> int | None:
        """Number of data sets by the formula in `few_values`, or None if it does not apply."""
        values = range(self.column.scale.steps + 1)
        sums = plain_sums(self.column) if len(values) <= few_values.VALUES else None
        if sums is None:
            return None
        runs = {total: [(squares[0], squares[-1])] for total, squares in sums.items()}
        return few_values.number_of_runs(values, self.column.n, runs) if runs else None

    @cached_property
    def refused(self) -> str:
        """Reason why the data sets are not counted, or "" if they can be counted."""
        if self._of_few_values is None:
            if self.targets.refused:
                return self.targets.refused
            try:
                self._require_countable()
            except UserError as error:
                return str(error)
        if self.listed_apart and self._unfiltered > LISTED:
            return (
                f"quartiles must be checked in each data set, but {self._unfiltered:,} data sets "
                f"match the other statistics, and no more than {LISTED:,} can be listed"
            )
        return ""

    def _require_countable(self) -> None:
        """Raise an error if counting multisets would take too much memory or time."""
        if self._parts("multisets") > MANY_PARTS:
            # Listing all parts is slow. One pair of sum and sum of squares needs smaller tables.
            wanted = self.targets.wanted
            some = problems(partition(wanted[len(wanted) // 2 :][:1]))
            require_countable(some, self.memory_gib, self.minutes)
        require_countable(self.problems, self.memory_gib, self.minutes)

    @property
    def listed_apart(self) -> bool:
        """Whether all data sets must be listed to check them against published quartiles."""
        return bool(self.column.lower_quartile or self.column.upper_quartile)

    @cached_property
    def listed(self) -> Array:
        """All multisets of ratings, one sorted row per multiset.

        Raises
        ------
        UserError
            If there are more than `LISTED` data sets.
        """
        if self._unfiltered > LISTED:
            raise UserError(
                "{reason} data sets are too many to list; draw a sample instead",
                reason=self._unfiltered,
            )
        rows = multisets(self.problems, self.column.n, self.memory_gib)
        return rows[are_met(self.column, rows)] if self.listed_apart else rows

    @cached_property
    def not_drawn(self) -> str:
        """Reason why data sets cannot be sampled, or "" if they can be sampled."""
        if self.refused:
            return self.refused
        try:
            require_memory(self.problems, self.memory_gib, len(moduli_above(self.multisets)))
        except UserError as error:
            return str(error)
        return ""

    @cached_property
    def not_ordered(self) -> str:
        """Reason why ordered samples are neither counted nor drawn, or "" if they can be."""
        if self.not_drawn or self.listed_apart:
            return self.not_drawn
        try:
            _ = self.ordered_problems
        except UserError as error:
            return str(error)
        return ""

    @cached_property
    def witness(self) -> tuple[int, ...]:
        """An example of a consistent data set, found without counting all data sets.

        Empty if the data sets can be counted or if the search found no data set.
        """
        return witness(self.column, self.targets) if self.refused else ()

    @cached_property
    def attained(self) -> tuple[tuple[tuple[int, int], ...], bool]:
        """Possible pairs of sum and sum of squares, and whether each pair is known to occur.

        A pair occurs if at least one data set has this sum and this sum of squares.
        """
        if self.not_drawn:
            return tuple((m.total, m.squares) for m in self.targets.moments), False
        if self.listed_apart:
            rows = self.listed.astype(np.int64)
            pairs = zip(rows.sum(axis=1).tolist(), (rows**2).sum(axis=1).tolist(), strict=True)
            return tuple(sorted(set(pairs))), True
        return tuple(sorted(attained(self.problems, self.memory_gib))), True

    @cached_property
    def ordered(self) -> int:
        """Number of data sets, counting different orders of participants separately."""
        if self.listed_apart:
            return int(sum(arrangements(self.listed)))
        return count(self.ordered_problems, "ordered", self.memory_gib)

    @property
    def consistent(self) -> bool:
        """Whether any data set is consistent with the column."""
        return self.multisets > 0

    @property
    def reason(self) -> str:
        """Reason why no data set is consistent with the column, or an empty string."""
        if self.targets.reason or self.consistent:
            return self.targets.reason
        return (
            "mean and SD pass GRIM and GRIMMER, but no set of ratings on the scale matches all "
            "published numbers together"
        )

    def under(self, sd_convention: str, rounding: str) -> Solutions:
        """Return the same column's solutions under a different SD convention and rounding rule."""
        other = {"sd_convention": sd_convention, "rounding": rounding}
        return replace(self, column=self.column.model_copy(update=other))
