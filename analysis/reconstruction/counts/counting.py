"""Count exactly how many data sets are consistent with a column."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isfinite, prod

import numpy as np

from slipscale.analysis.reconstruction.counts import plane_by_plane
from slipscale.analysis.reconstruction.counts.meet_in_the_middle import Joint
from slipscale.analysis.reconstruction.counts.problem import (
    MEMORY_GIB,
    MINUTES,
    Problem,
    require_countable,
    require_memory,
    simple_bound,
)
from slipscale.analysis.reconstruction.counts.residues import WORD, join, primes


def total(joint: Joint, modulus: int | None) -> float | int:
    """Return the number of solutions that a `Joint` represents, modulo `modulus`."""
    if modulus is None or modulus == WORD:
        # `einsum` avoids a temporary product. Machine words wrap, as required modulo 2^64.
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
    """A floating-point estimate of a count, with a bound on its error.

    Parameters
    ----------
    value : float
        Estimated count, which is infinite if it exceeds the floating-point range.
    error : float
        Bound on the relative error: 2^-53 per rounding, because only positive terms are added.
    """

    value: float
    error: float

    @property
    def bound(self) -> float:
        """Upper bound on the count."""
        return self.value * (1 + 2 * self.error) + 1

    def settles(self, modulus: int) -> bool:
        """Return whether the estimate is accurate enough to find the count from its residue."""
        return isfinite(self.value) and 2 * self.bound * self.error < modulus / 4

    def nearest(self, residue: int, modulus: int) -> int:
        """Return the integer with the given residue that is nearest to the estimate."""
        half = modulus // 2
        return int(self.value) + (residue - int(self.value) + half) % modulus - half


def estimate(tasks: list[Problem], measure: str) -> Estimate:
    """Estimate the number of solutions in floating-point arithmetic."""
    value, roundings = 0.0, 0
    with np.errstate(over="ignore", invalid="ignore"):
        for task in tasks:
            tables = task.tables(measure, None)
            # Each step adds at most k terms, each multiplied by a number of arrangements.
            steps = sum(len(table.distances()) * (len(table.planes) + 3) for table in tables)
            for joint in task.joints(*tables):
                value += float(total(joint, None))
                roundings = max(roundings, steps + joint.below.size) + 4
    return Estimate(value if isfinite(value) else inf, roundings * 2.0**-53)


def largest_possible(tasks: list[Problem], measure: str) -> int:
    """Return an upper bound on the number of solutions, which is tight if the number is large."""
    bound = simple_bound(tasks, measure)
    if bound < WORD:
        return bound
    close = estimate(tasks, measure).bound
    return int(close) + 1 if isfinite(close) else bound


def count(
    tasks: list[Problem],
    measure: str,
    memory_gib: float = MEMORY_GIB,
    minutes: float = MINUTES,
) -> int:
    """Return the exact number of solutions.

    Parameters
    ----------
    tasks : list of Problem
        Subproblems of a column, whose counts are added.
    measure : {"multisets", "ordered"}
    memory_gib : float
        Available memory in GiB.
    minutes : float
        Limit on the predicted time for counting multisets, in minutes.
    """
    if measure == "ordered":
        require_memory(tasks, memory_gib)
        return _exact(
            simple_bound(tasks, measure),
            lambda: estimate(tasks, measure),
            lambda modulus: _residue(tasks, measure, modulus),
        )
    require_countable(tasks, memory_gib, minutes)
    few = [task.of_few_values for task in tasks]
    many = [task for task, found in zip(tasks, few, strict=True) if found is None]
    return sum(found for found in few if found is not None) + _exact(
        simple_bound(many, measure),
        lambda: _estimated_multisets(many),
        lambda modulus: sum(int(_multisets(task, modulus)) for task in many) % modulus,
    )


def _exact(bound: int, estimated: Callable[[], Estimate], residue: Callable[[int], int]) -> int:
    """Return the exact count, using as few residues as possible."""
    if bound < WORD:
        return residue(WORD) if bound else 0
    close = estimated()
    moduli: tuple[int, ...] = (WORD,)
    while not close.settles(prod(moduli)) and prod(moduli) <= bound:
        moduli = (WORD, *primes(len(moduli)))
    found = join(tuple(residue(modulus) for modulus in moduli), moduli)
    return close.nearest(found, prod(moduli)) if close.settles(prod(moduli)) else found


def _multisets(task: Problem, modulus: int | None) -> float | int:
    return plane_by_plane.number(task.below, task.above, task.goals, modulus)


def _estimated_multisets(tasks: list[Problem]) -> Estimate:
    with np.errstate(over="ignore", invalid="ignore"):
        value = sum(float(_multisets(task, None)) for task in tasks)
    roundings = max(
        plane_by_plane.roundings(task.below, task.above, task.goals) for task in tasks
    ) + len(tasks)
    return Estimate(value if isfinite(value) else inf, roundings * 2.0**-53)


def attained(tasks: list[Problem], memory_gib: float = MEMORY_GIB) -> set[tuple[int, int]]:
    """Return the pairs of sum and sum of squares that have at least one solution."""
    require_memory(tasks, memory_gib)
    found = set()
    for task in tasks:
        # All terms are at least 1, so none is lost in floating point.
        for joint in task.joints(*task.tables("multisets", None)):
            if total(joint, None) > 0:
                found.add(joint.goal.part.all_moments)
    return found


def _residue(tasks: list[Problem], measure: str, modulus: int) -> int:
    found = 0
    for task in tasks:
        for joint in task.joints(*task.tables(measure, modulus)):
            found += int(total(joint, modulus))
    return found % modulus
