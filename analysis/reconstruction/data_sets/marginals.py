"""Compute the exact distributions of order statistics and ratings over all data sets.

As in `unranking`, the additions that filled a state table are undone one distance at a time,
starting with the distance nearest to the centre (a reference value on the scale). For each state, a
second table contains the number of ways to complete the solution. At each distance, the product of
the state table and the second table gives the number of solutions with 0, 1, 2, ... values at this
distance or beyond.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.counts.counting import largest_possible, total
from slipscale.analysis.reconstruction.counts.meet_in_the_middle import Goal, joints
from slipscale.analysis.reconstruction.counts.problem import Problem, require_memory
from slipscale.analysis.reconstruction.counts.residues import WORD, join, moduli_above
from slipscale.analysis.reconstruction.counts.state_table import Array, StateTable

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions


@dataclass(frozen=True)
class Marginals:
    """The distributions of ratings over all data sets consistent with a column.

    Parameters
    ----------
    n : int
        Number of ratings in a data set.
    total : int
        Number of data sets, either multisets or ordered samples.
    at_most : tuple of tuple of int
        ``at_most[v][m]`` is the number of data sets with exactly m ratings of at most v steps above
        the minimum.
    absent : tuple of int
        ``absent[v]`` is the number of data sets that contain no rating v steps above the minimum.
    """

    n: int
    total: int
    at_most: tuple[tuple[int, ...], ...]
    absent: tuple[int, ...]

    def order_statistic(self, i: int) -> dict[int, Fraction]:
        """Return the distribution of the i-th smallest rating (1 to n) as {value: probability}."""
        reached = [0, *(sum(counts[i:]) for counts in self.at_most)]
        return {
            v: Fraction(reached[v + 1] - reached[v], self.total)
            for v in range(len(self.at_most))
            if reached[v + 1] > reached[v]
        }

    def rating(self) -> dict[int, Fraction]:
        """Return the distribution of ratings, pooled over all data sets."""
        mean = [0, *(sum(m * c for m, c in enumerate(counts)) for counts in self.at_most)]
        return {
            v: Fraction(mean[v + 1] - mean[v], self.n * self.total)
            for v in range(len(self.at_most))
            if mean[v + 1] > mean[v]
        }

    def presence(self, value: int) -> Fraction:
        """Return the proportion of data sets that contain a given rating."""
        return 1 - Fraction(self.absent[value], self.total)


def marginals(solutions: Solutions, measure: str = "multisets") -> Marginals:
    """Compute the exact distributions of ratings over all solutions.

    Parameters
    ----------
    solutions : Solutions
        Solutions of a column. At least one data set must be consistent with the column.
    measure : {"multisets", "ordered"}
        Whether to treat all multisets or all ordered samples as equally likely.
    """
    n, values = solutions.column.n, solutions.column.scale.steps + 1
    tasks = solutions.ordered_problems if measure == "ordered" else solutions.problems
    moduli = moduli_above(largest_possible(tasks, measure))
    require_memory(tasks, solutions.memory_gib, 2)
    at_most, absent = np.zeros((values, n + 1), dtype=object), np.zeros(values, dtype=object)
    for task in tasks:
        for goal in task.goals:
            parts = [_goal(task, goal, measure, modulus) for modulus in moduli]
            tally = {
                key: join(tuple(part.get(key, 0) for part in parts), moduli)
                for key in set().union(*parts)
            }
            _add(task, goal, tally, at_most, absent)
    return Marginals(
        n, int(sum(at_most[-1])), tuple(tuple(map(int, r)) for r in at_most), tuple(absent)
    )


# Numbers of solutions with exactly m free values up to `value` (key: value, m), without a free
# value equal to `value` (key: value, None), and in total (key: `WHOLE`).
Tally = dict[tuple[int, int | None], int]
WHOLE = (-1, None)


def _goal(task: Problem, goal: Goal, measure: str, modulus: int) -> Tally:
    """Return the `Tally` of the solutions of one goal, modulo `modulus`."""
    below, above = task.tables(measure, modulus)
    outlines = (task.below, task.above)
    whole = joints(goal, outlines, (below.planes, above.planes), measure)
    tally: Tally = {WHOLE: sum(int(total(joint, modulus)) for joint in whole) % modulus}
    for own_below in (True, False):
        own, other = (below, above) if own_below else (above, below)
        worth = StateTable(own.shape, measure, modulus)
        worth.flat[:] = 0
        pair = (worth.planes, other.planes) if own_below else (other.planes, worth.planes)
        for joint in joints(goal, outlines, pair, measure):
            mine, theirs = (joint.below, joint.above) if own_below else (joint.above, joint.below)
            mine[...] += worth.scaled(theirs, joint.ways)
        for distance in range(own.shape.nearest, own.shape.farthest + 1):
            value = task.split.centre + (-distance if own_below else distance)
            # If the two intervals share a value, both tables are needed to count values up to it.
            shared = value == task.split.below == task.split.above
            for k, number in enumerate(() if shared else _products(own, worth)):
                key = (value, k) if own_below else (value - 1, goal.n - k)
                tally[key] = number
            # Excluded values (holes) were not added to the tables, so they are not removed.
            if distance not in own.shape.holes:
                own.retreat(distance)
            tally[value, None] = sum(_products(own, worth)) % modulus
            if distance not in own.shape.holes:
                worth.pull_back(distance)
        own.fill()
    return tally


def _products(own: StateTable, worth: StateTable) -> list[int]:
    """Return the number of solutions with 0, 1, 2, ... values at the distances in `own`."""
    modulus = own.modulus or WORD
    found = []
    for counts, weights in zip(own.planes, worth.planes, strict=True):
        product: Array = own.scaled(counts * weights, 1)
        found.append(int(product.sum()) % modulus)
    return found


def _add(task: Problem, goal: Goal, tally: Tally, at_most: Array, absent: Array) -> None:
    """Add the counts in `tally` to `at_most` and `absent`, taking the fixed values into account."""
    split, n = task.split, goal.n
    given = goal.part.given
    covered = {value for value, m in tally if m is not None}
    whole = tally[WHOLE]
    for value in range(len(at_most)):
        held = sum(times for v, times in given if v <= value)
        # Between the two intervals of free values, the counts do not change. Below both intervals,
        # they include no free values; above both, all free values.
        near = split.below if split.below < value < split.above else value
        if near in covered:
            for m in range(n + 1):
                at_most[value, m + held] += tally.get((near, m), 0)
        else:
            at_most[value, held + (n if near >= split.low else 0)] += whole
        if all(v != value for v, _ in given):
            absent[value] += tally.get((value, None), whole)
