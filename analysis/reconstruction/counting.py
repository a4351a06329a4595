"""Exact counts of the solutions of a column, of any size, and what they would cost."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb, isfinite
from typing import TYPE_CHECKING

import numpy as np

from analysis.reconstruction.meeting import Goal, Joint, goals, joints, shapes
from analysis.reconstruction.residues import WORD, join, moduli_above
from analysis.reconstruction.side import Shape, Side
from faults import UserError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from analysis.reconstruction.pieces import Piece, Split

# A state table larger than this is refused unless the user allows more.
MEMORY_GIB = 4.0
# Rounding errors of sums of positive numbers stay far below this.
SAFETY = 1.000001


@dataclass(frozen=True)
class Problem:
    """Pieces that share their tables.

    Parameters
    ----------
    split : Split
        Where the free values lie.
    goals : tuple of Goal
        What they must meet.
    below, above : Shape
        The tables of the two sides.
    """

    split: Split
    goals: tuple[Goal, ...]
    below: Shape
    above: Shape

    @property
    def bytes(self) -> int:
        """Memory of both tables, one modulus."""
        return 8 * (self.below.cells + self.above.cells)

    def sides(self, measure: str, modulus: int | None) -> tuple[Side, Side]:
        """Return the two tables, filled."""
        return Side(self.below, measure, modulus).fill(), Side(self.above, measure, modulus).fill()

    def joints(self, below: Side, above: Side) -> list[Joint]:
        """Return every pair of aligned slices."""
        return [
            joint
            for goal in self.goals
            for joint in joints(
                goal, (self.below, self.above), (below.planes, above.planes), below.measure
            )
        ]


def problems(pieces: Iterable[Piece]) -> list[Problem]:
    """Return `pieces` grouped by what shares its tables."""
    return [
        Problem(split, tuple(wanted), *shapes(split, wanted))
        for split, wanted in goals(pieces).items()
    ]


def require_memory(tasks: list[Problem], memory_gib: float, moduli: int = 1) -> None:
    """Refuse what would not fit, before it starts.

    Raises
    ------
    UserError
        The largest table needs more than `memory_gib`.
    """
    need = max((task.bytes for task in tasks), default=0) * moduli / 2**30
    if need > memory_gib:
        raise UserError(
            f"the table of states needs about {need:.1f} GiB, more than the {memory_gib:g} GiB "
            "allowed: narrow the scale (observed_minimum, observed_maximum, maximum_deviation) "
            "or allow more with --memory-gib"
        )


def total(joint: Joint, modulus: int | None) -> float | int:
    """Return the number of solutions in a pair of slices, modulo `modulus`."""
    product = joint.below * joint.above
    if modulus is None:
        return float(product.sum()) * float(joint.ways)
    if modulus != WORD:
        divisor = np.uint64(modulus)
        product -= product // divisor * divisor
    return int(product.sum()) * joint.ways % modulus


def largest_possible(tasks: list[Problem], measure: str) -> int:
    """Return an upper bound on the number of solutions, and of every goal's.

    First what n free values could be at all, each given one's places included; if that
    exceeds a machine word, an estimate in floating point, whose relative error is below the
    number of additions times 2^-53.
    """
    bound = 0
    for task in tasks:
        values = max(task.split.high - task.split.low + 1, 1)
        for goal in task.goals:
            free = values**goal.n if measure == "ordered" else comb(goal.n + values - 1, goal.n)
            bound += free * (goal.piece.arrangements if measure == "ordered" else 1)
    if bound < WORD:
        return bound
    with np.errstate(over="ignore", invalid="ignore"):
        estimate = 0.0
        for task in tasks:
            for joint in task.joints(*task.sides(measure, None)):
                estimate += total(joint, None)
    if not isfinite(estimate):
        return bound
    return int(estimate * SAFETY) + 1


def count(tasks: list[Problem], measure: str, memory_gib: float = MEMORY_GIB) -> int:
    """Return the exact number of solutions.

    Parameters
    ----------
    tasks : list of Problem
        The pieces of a column.
    measure : {"multisets", "ordered"}
        What is counted.
    memory_gib : float
        Memory allowed to one table of states.

    Returns
    -------
    int
        Of any size.
    """
    require_memory(tasks, memory_gib)
    if not tasks:
        return 0
    moduli = moduli_above(largest_possible(tasks, measure))
    residues = []
    for modulus in moduli:
        found = 0
        for task in tasks:
            for joint in task.joints(*task.sides(measure, modulus)):
                found += int(total(joint, modulus))
        residues.append(found % modulus)
    return join(tuple(residues), moduli)
