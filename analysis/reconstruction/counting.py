"""Exact counts of the solutions of a column, of any size, and what they would cost."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, comb, inf, isfinite
from typing import TYPE_CHECKING

import numpy as np

from analysis.reconstruction.meet_in_the_middle import (
    Goal,
    Joint,
    goals,
    joints,
    rough_cells,
    shapes,
)
from analysis.reconstruction.residues import WORD, join, moduli_above
from analysis.reconstruction.state_table import Shape, StateTable
from faults import UserError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from analysis.reconstruction.partition import Part, Split

# A state table larger than this is refused unless the user allows more.
MEMORY_GIB = 4.0
# Steps between the least and the largest rating.
WIDEST = 10_000_000
# Measured at n = 30 to 100 on 0 to 100 and at n = 60 on 0 to 7, an ordinary processor: 30 to 43.
NANOSECONDS_A_CELL = 40
BITS_A_PASS = 62


@dataclass(frozen=True)
class Problem:
    """Parts of the solutions that share their tables.

    Parameters
    ----------
    split : Split
        Where the free values lie.
    goals : tuple of Goal
        What they must add up to.
    below, above : Shape
        The tables of the values below and above the centre.
    """

    split: Split
    goals: tuple[Goal, ...]
    below: Shape
    above: Shape

    @property
    def bytes(self) -> int:
        """Memory of both tables, one modulus."""
        return 8 * (self.below.cells + self.above.cells)

    def tables(self, measure: str, modulus: int | None) -> tuple[StateTable, StateTable]:
        """Return the two tables, filled."""
        return StateTable(self.below, measure, modulus).fill(), StateTable(
            self.above, measure, modulus
        ).fill()

    def joints(self, below: StateTable, above: StateTable) -> list[Joint]:
        """Return every pair of aligned slices."""
        return [
            joint
            for goal in self.goals
            for joint in joints(
                goal, (self.below, self.above), (below.planes, above.planes), below.measure
            )
        ]


def problems(parts: Iterable[Part], memory_gib: float = MEMORY_GIB) -> list[Problem]:
    """Return `parts` grouped by what shares its tables.

    Raises
    ------
    UserError
        Values lie too far apart, or a table would clearly need more than `memory_gib`.
    """
    groups = goals(parts)
    for split, wanted in groups.items():
        if split.high - split.low > WIDEST:
            raise UserError(
                f"ratings may lie {split.high - split.low:,} steps apart, more than {WIDEST:,}: "
                "narrow the scale (observed_minimum, observed_maximum, maximum_deviation)"
            )
        # The exact size takes long where the tables are large; a guess does not.
        guess_gib = 8 * rough_cells(split, wanted) / 2**30
        if guess_gib > 2 * memory_gib:
            raise _too_large(guess_gib, memory_gib)
    return [
        Problem(split, tuple(wanted), *shapes(split, wanted)) for split, wanted in groups.items()
    ]


def _too_large(need_gib: float, memory_gib: float) -> UserError:
    seconds = need_gib * 2**30 / 8 * NANOSECONDS_A_CELL * 1e-9
    return UserError(
        f"the table of states needs about {need_gib:.1f} GiB, more than the {memory_gib:g} GiB "
        f"allowed, and {duration(seconds)} or more to fill: narrow the scale "
        "(observed_minimum, observed_maximum, maximum_deviation) or allow more with --memory-gib"
    )


def require_memory(tasks: list[Problem], memory_gib: float, moduli: int = 1) -> None:
    """Refuse what would not fit, before it starts.

    Raises
    ------
    UserError
        The largest table needs more than `memory_gib`.
    """
    need = max((task.bytes for task in tasks), default=0) * moduli / 2**30
    if need > memory_gib:
        raise _too_large(need, memory_gib)


def seconds_to_count(tasks: list[Problem]) -> float:
    """Return about how long counting the multisets takes on an ordinary processor."""
    bits = simple_bound(tasks, "multisets").bit_length()
    # Once in floating point, and once for each modulus.
    passes = 1 if bits <= BITS_A_PASS else 1 + ceil(bits / BITS_A_PASS)
    return sum(task.bytes // 8 for task in tasks) * passes * NANOSECONDS_A_CELL * 1e-9


def duration(seconds: float) -> str:
    """Return a length of time for people.

    >>> duration(0.2), duration(90), duration(7200)
    ('about 1 s', 'about 2 min', 'about 2 h')
    """
    for size, unit in ((3600, "h"), (60, "min")):
        if seconds >= size:
            return f"about {ceil(seconds / size):,} {unit}"
    return f"about {max(round(seconds), 1)} s"


def total(joint: Joint, modulus: int | None) -> float | int:
    """Return the number of solutions in a pair of slices, modulo `modulus`."""
    if modulus is None or modulus == WORD:
        # No product in memory; machine words wrap, as residues of 2^64 should.
        found = np.einsum("ij,ij", joint.below, joint.above)
        if modulus is None:
            return float(found) * float(joint.ways)
        return int(found) * joint.ways % WORD
    product = joint.below * joint.above
    divisor = np.uint64(modulus)
    product -= product // divisor * divisor
    return int(product.sum()) * joint.ways % modulus


@dataclass(frozen=True)
class Estimate:
    """A count in floating point and how far it can be off.

    Parameters
    ----------
    value : float
        Infinite if it exceeds what floating point holds.
    error : float
        Bound on the relative error. Every term is positive and passes through no more than so
        many roundings, each of relative size 2^-53.
    """

    value: float
    error: float

    @property
    def bound(self) -> float:
        """A number that the count does not exceed."""
        return self.value * (1 + 2 * self.error) + 1

    @property
    def settles_a_residue(self) -> bool:
        """Whether only one number with a known residue modulo 2^64 is near enough."""
        return isfinite(self.value) and 2 * self.bound * self.error < WORD / 4

    def nearest(self, residue: int) -> int:
        """Return the nearest integer that leaves `residue` modulo 2^64."""
        half = WORD // 2
        return int(self.value) + (residue - int(self.value) + half) % WORD - half


def estimate(tasks: list[Problem], measure: str) -> Estimate:
    """Return the number of solutions in floating point."""
    value, roundings = 0.0, 0
    with np.errstate(over="ignore", invalid="ignore"):
        for task in tasks:
            tables = task.tables(measure, None)
            # A step adds up to k terms, each times a number of arrangements.
            steps = sum(len(table.distances()) * (len(table.planes) + 3) for table in tables)
            for joint in task.joints(*tables):
                value += float(total(joint, None))
                roundings = max(roundings, steps + joint.below.size) + 4
    return Estimate(value if isfinite(value) else inf, roundings * 2.0**-53)


def simple_bound(tasks: list[Problem], measure: str) -> int:
    """Return what the free values could be at all, each given one's places included."""
    bound = 0
    for task in tasks:
        values = max(task.split.high - task.split.low + 1, 1)
        for goal in task.goals:
            free = values**goal.n if measure == "ordered" else comb(goal.n + values - 1, goal.n)
            bound += free * (goal.part.arrangements if measure == "ordered" else 1)
    return bound


def largest_possible(tasks: list[Problem], measure: str) -> int:
    """Return an upper bound on the number of solutions, close if it exceeds a machine word."""
    bound = simple_bound(tasks, measure)
    if bound < WORD:
        return bound
    close = estimate(tasks, measure).bound
    return int(close) + 1 if isfinite(close) else bound


def count(tasks: list[Problem], measure: str, memory_gib: float = MEMORY_GIB) -> int:
    """Return the exact number of solutions.

    Parameters
    ----------
    tasks : list of Problem
        The parts of a column.
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
    bound = simple_bound(tasks, measure)
    if bound < WORD:
        return _residue(tasks, measure, WORD)
    close = estimate(tasks, measure)
    if close.settles_a_residue:
        return close.nearest(_residue(tasks, measure, WORD))
    moduli = moduli_above(int(close.bound) + 1 if isfinite(close.bound) else bound)
    return join(tuple(_residue(tasks, measure, modulus) for modulus in moduli), moduli)


def attained(tasks: list[Problem], memory_gib: float = MEMORY_GIB) -> set[tuple[int, int]]:
    """Return the pairs of a sum and a sum of squares that some solution has."""
    require_memory(tasks, memory_gib)
    found = set()
    for task in tasks:
        # Terms are positive and at least 1: floating point loses none of them.
        for joint in task.joints(*task.tables("multisets", None)):
            if total(joint, None) > 0:
                found.add(joint.goal.part.all_moments)
    return found


def _residue(tasks: list[Problem], measure: str, modulus: int) -> int:
    """Return the number of solutions modulo `modulus`."""
    found = 0
    for task in tasks:
        for joint in task.joints(*task.tables(measure, modulus)):
            found += int(total(joint, modulus))
    return found % modulus
