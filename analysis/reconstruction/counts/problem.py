"""Divide a column's count into problems with one pair of state tables each; estimate the cost."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import ceil, comb

import numpy as np

from slipscale.analysis.reconstruction.counts import few_values, plane_by_plane
from slipscale.analysis.reconstruction.counts.meet_in_the_middle import (
    Goal,
    Joint,
    glimpses,
    goals,
    joints,
    shapes,
)
from slipscale.analysis.reconstruction.counts.partition import Part, Split
from slipscale.analysis.reconstruction.counts.state_table import Shape, StateTable
from slipscale.faults import UserError

# Default limits on the memory for tables and on the time for a count.
MEMORY_GIB = 4.0
MINUTES = 0.1
# Maximum number of steps between the smallest and the largest rating.
WIDEST = 10_000_000
# Measured: 1.3 to 2.4, with n = 50 to 200 on a scale from 0 to 100, and n = 200 on 1 to 7.
NANOSECONDS_AN_ADDITION = 2.0
# Measured: 11 to 14 µs and 600 bytes, with n = 20 to 100 on a scale from 0 to 100.
SECONDS_A_PART = 15e-6
BYTES_A_PART = 1000
# Counts of up to this number of bits need a single pass. Larger counts also need one pass in
# floating point and one pass per additional `BITS_A_PASS` bits.
WORD_BITS = 64
BITS_A_PASS = 31


@dataclass(frozen=True)
class Problem:
    """The parts of a partition whose solutions are counted with the same pair of state tables.

    Parameters
    ----------
    split : Split
        Intervals that contain the free values.
    goals : tuple of Goal
        Requirements on the free values, one `Goal` per part.
    """

    split: Split
    goals: tuple[Goal, ...]

    @cached_property
    def _shapes(self) -> tuple[Shape, Shape]:
        return shapes(self.split, list(self.goals))

    @property
    def below(self) -> Shape:
        """Shape of the state table for values below the centre."""
        return self._shapes[0]

    @property
    def above(self) -> Shape:
        """Shape of the state table for values at or above the centre."""
        return self._shapes[1]

    @cached_property
    def of_few_values(self) -> int | None:
        """Number of multisets by the formula in `few_values`, or None if it does not apply."""
        if not all(map(few_values.without_median, self.goals)):
            return None
        split = self.split
        if split.high - split.low > 2 * few_values.VALUES:
            return None
        values = [v for v in range(split.low, split.high + 1) if v not in split.holes]
        return few_values.number(values, self.goals)

    @property
    def bytes(self) -> int:
        """Memory in bytes for both state tables with one modulus."""
        return 8 * (self.below.cells + self.above.cells)

    @property
    def count_bytes(self) -> int:
        """Memory in bytes for counting multisets."""
        return 8 * plane_by_plane.cells(self.below, self.above, self.goals)

    @cached_property
    def rough(self) -> Rough:
        """Approximate cost of the problem, estimated quickly from a few planes."""
        return _rough(self)

    def tables(self, measure: str, modulus: int | None) -> tuple[StateTable, StateTable]:
        """Return the filled state tables for values below the centre, and at or above it."""
        return StateTable(self.below, measure, modulus).fill(), StateTable(
            self.above, measure, modulus
        ).fill()

    def joints(self, below: StateTable, above: StateTable) -> list[Joint]:
        """Return all pairs of aligned slices of the two state tables (see `Joint`)."""
        return [
            joint
            for goal in self.goals
            for joint in joints(
                goal, (self.below, self.above), (below.planes, above.planes), below.measure
            )
        ]


@dataclass(frozen=True)
class Rough:
    """The approximate cost of a counting problem.

    Parameters
    ----------
    table_gib, count_gib : float
        Memory in GiB for both state tables, and for counting multisets.
    additions : float
        Number of additions per modulus for counting multisets.
    """

    table_gib: float
    count_gib: float
    additions: float


def problems(parts: Iterable[Part]) -> list[Problem]:
    """Group the parts of a partition by the pair of state tables that they need.

    Raises
    ------
    UserError
        If the range of possible ratings is too wide.
    """
    groups = goals(parts)
    for split in groups:
        if split.high - split.low > WIDEST:
            raise UserError(
                "ratings can differ by up to {width:,} steps, but no more than {widest:,} steps"
                " are supported: {remedy}",
                width=split.high - split.low,
                widest=WIDEST,
                remedy=NARROW,
            )
    return [Problem(split, tuple(wanted)) for split, wanted in groups.items()]


def require_memory(tasks: list[Problem], memory_gib: float, moduli: int = 1) -> None:
    """Raise an error if the state tables would not fit in memory.

    Raises
    ------
    UserError
        If the largest table needs more than `memory_gib`.
    """
    for task in tasks:
        # The exact size of large tables is slow to compute, so it is estimated first.
        guess_gib = task.rough.table_gib * moduli
        need_gib = guess_gib if guess_gib > 2 * memory_gib else task.bytes * moduli / 2**30
        if need_gib > memory_gib:
            raise UserError(
                "the state table needs about {need_gib:.1f} GiB, but {memory_gib:g} GiB are "
                "allowed: {remedy}, or increase --memory-gib",
                need_gib=need_gib,
                memory_gib=memory_gib,
                remedy=NARROW,
            )


def require_listable(parts: int, memory_gib: float, minutes: float) -> None:
    """Raise an error if the parts of a partition would take too much memory or time to list.

    Raises
    ------
    UserError
        If there are more parts than `memory_gib` and `minutes` allow.
    """
    need_gib, seconds = parts * BYTES_A_PART / 2**30, parts * SECONDS_A_PART
    if seconds > 60 * minutes or need_gib > memory_gib:
        raise UserError(
            "up to {parts:,} combinations of a sum, a sum of squares, extreme and middle "
            "ratings and frequencies need about {need_gib:.1f} GiB and take {duration}; "
            "{memory_gib:g} GiB and {minutes:g} min are allowed: {remedy}, or increase "
            "--memory-gib and --minutes",
            parts=parts,
            need_gib=need_gib,
            duration=duration(seconds),
            memory_gib=memory_gib,
            minutes=minutes,
            remedy=NARROW,
        )


NARROW = "narrow the scale with observed_minimum, observed_maximum or maximum_deviation"


def require_countable(tasks: list[Problem], memory_gib: float, minutes: float) -> None:
    """Raise an error if a count would take too much memory or time.

    Raises
    ------
    UserError
        If a count needs more memory than `memory_gib`, or if all counts together take longer than
        about `minutes`.
    """
    large = _large(tasks)
    seconds = seconds_to_count(tasks)
    need_gib = max((task.rough.count_gib for task in large), default=0.0)
    if seconds <= 60 * minutes and need_gib <= 2 * memory_gib:
        # The exact memory is slow to compute, and is needed only if the estimate is not too high.
        need_gib = max((task.count_bytes for task in large), default=0) / 2**30
        if need_gib <= memory_gib:
            return
    raise UserError(
        "counting needs about {need_gib:.1f} GiB and takes {duration}; {memory_gib:g} GiB and "
        "{minutes:g} min are allowed: {remedy}, or increase --memory-gib and --minutes",
        need_gib=need_gib,
        duration=duration(seconds),
        memory_gib=memory_gib,
        minutes=minutes,
        remedy=NARROW,
    )


def _large(tasks: Iterable[Problem]) -> list[Problem]:
    return [task for task in tasks if task.of_few_values is None]


def seconds_to_count(tasks: Sequence[Problem]) -> float:
    """Estimate the time to count all multisets, in seconds."""
    large = _large(tasks)
    bits = simple_bound(large, "multisets").bit_length()
    passes = 1 if bits <= WORD_BITS else 2 + ceil((bits - WORD_BITS) / BITS_A_PASS)
    additions = sum(task.rough.additions for task in large)
    return additions * passes * NANOSECONDS_AN_ADDITION * 1e-9


def duration(seconds: float) -> str:
    """Format a duration in words.

    >>> duration(0.2), duration(90), duration(7200)
    ('about 1 s', 'about 2 min', 'about 2 h')
    """
    for size, unit in ((3600, "h"), (60, "min")):
        if seconds >= size:
            return f"about {ceil(seconds / size):,} {unit}"
    return f"about {max(round(seconds), 1)} s"


def simple_bound(tasks: Iterable[Problem], measure: str) -> int:
    """Return a rough upper bound on the number of solutions."""
    bound = 0
    choose = cache(comb)  # The problems of a column need almost the same coefficients.
    for task in tasks:
        values = max(task.split.high - task.split.low + 1, 1)
        for goal in task.goals:
            free = values**goal.n if measure == "ordered" else choose(goal.n + values - 1, goal.n)
            bound += free * (goal.part.arrangements if measure == "ordered" else 1)
    return bound


def _rough(task: Problem) -> Rough:
    tables, held, additions = 0.0, 0.0, 0.0
    for half in glimpses(task.split, list(task.goals)):
        tables += float(np.trapezoid(half.cells, half.ks)) + 1
        held += half.share * float(half.sizes.max(axis=0, initial=0).sum())
        additions += half.share * float(np.trapezoid(half.sizes.sum(axis=1), half.ks))
    return Rough(8 * tables / 2**30, 8 * held / 2**30, additions)
