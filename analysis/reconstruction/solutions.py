"""All data sets behind one published column: is there any, how many, which."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

from analysis.reconstruction.constraints import Targets, targets
from analysis.reconstruction.counting import MEMORY_GIB, Problem, count, problems
from analysis.reconstruction.partition import partition

if TYPE_CHECKING:
    from analysis.reconstruction.published_table import Column


@dataclass(frozen=True)
class Solutions:
    """Every data set that `column` allows.

    Parameters
    ----------
    column : Column
        As published.
    memory_gib : float
        Memory allowed to one table of states; a larger one is refused before it starts.
    """

    column: Column
    memory_gib: float = MEMORY_GIB

    @cached_property
    def targets(self) -> Targets:
        """Admissible sums and sums of squares, or why there is none."""
        return targets(self.column)

    @cached_property
    def problems(self) -> list[Problem]:
        """The parts to solve, grouped by what shares its tables."""
        return problems(part for wish in self.targets.wanted for part in partition(wish))

    @cached_property
    def multisets(self) -> int:
        """Number of data sets when the order of the participants does not count."""
        return count(self.problems, "multisets", self.memory_gib)

    @cached_property
    def ordered(self) -> int:
        """Number of data sets when it is known which participant gave which rating."""
        return count(self.problems, "ordered", self.memory_gib)

    @property
    def consistent(self) -> bool:
        """Whether there is any."""
        return self.multisets > 0

    @property
    def reason(self) -> str:
        """Why there is none; empty if there is."""
        if self.targets.reason or self.consistent:
            return self.targets.reason
        return (
            "mean and SD each pass GRIM and GRIMMER, but no set of ratings on the scale has both "
            "together with the extremes or median printed"
        )

    def under(self, sd_convention: str, rounding: str) -> Solutions:
        """Return the solutions under another convention and rounding rule."""
        other = {"sd_convention": sd_convention, "rounding": rounding}
        return replace(self, column=self.column.model_copy(update=other))
