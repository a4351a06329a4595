"""Count multisets by a formula for scales with few values, such as Likert scales.

Choose three neighbouring values c - 1, c and c + 1. Only the frequencies of the other values (the
outer values) are enumerated. For a given choice of these frequencies, let k be the number of outer
values, d the sum of their signed distances from c, and q the sum of their squared distances.
Together with the required totals n, D and V (see `meet_in_the_middle`), they determine the
frequencies of the three neighbouring values: the frequencies of c + 1 and c - 1 add up to w = V - q
and differ by D - d. None of the three is negative if and only if ``|D - d| <= w <= n - k``. If the
possible sums of squares form a range with step 2, so do the possible values of w. One subtraction
therefore gives the number of multisets for each choice of the frequencies of outer values.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from slipscale.analysis.reconstruction.counts.meet_in_the_middle import Goal
from slipscale.analysis.reconstruction.counts.state_table import Array

# Maximum number of combinations of outer values. Beyond this number, another method is faster.
CHOICES = 100_000
# Scales with more values than this always exceed `CHOICES`.
VALUES = 12


# Possible sums of squares, keyed by sum. They form arithmetic sequences with a common difference of
# 2, each given by its first and last element.
Runs = dict[int, list[tuple[int, int]]]


def number(values: Sequence[int], goals: Iterable[Goal]) -> int | None:
    """Return the number of multisets of `values` that have the moments required by any of `goals`.

    `values` must be in ascending order. Returns None if other methods are faster, or if no three
    values are consecutive.
    """
    groups: dict[int, dict[int, list[int]]] = defaultdict(lambda: defaultdict(list))
    for goal in goals:
        groups[goal.n][goal.part.moments.total].append(goal.part.moments.squares)
    found = 0
    for n, of_sum in groups.items():
        runs = {total: list(_runs(sorted(squares))) for total, squares in of_sum.items()}
        of_n = number_of_runs(values, n, runs)
        if of_n is None:
            return None
        found += of_n
    return found


def number_of_runs(values: Sequence[int], n: int, of_sum: Runs) -> int | None:
    """Return the number of multisets of n values with one of the given sums and sums of squares.

    Parameters
    ----------
    values : sequence of int
        Values in ascending order.
    n : int
        Number of values in a multiset.
    of_sum : dict of int to list of (int, int)
        For each sum, the possible sums of squares, as sequences with a step of two. Each sequence
        is given by its first and last element.
    """
    centres = [b for a, b, c in zip(values, values[1:], values[2:], strict=False) if c - a == 2]  # noqa: PLR2004
    if not centres or len(values) > VALUES:
        return None
    # If the centre is close to the mean, fewer combinations of outer values are possible.
    mean = sum(of_sum) / max(len(of_sum) * n, 1)
    centre = min(centres, key=lambda c: abs(c - mean))
    shifted = {
        total - n * centre: [
            (least - 2 * centre * total + n * centre**2, most - 2 * centre * total + n * centre**2)
            for least, most in runs
        ]
        for total, runs in of_sum.items()
    }
    least = min((first for runs in shifted.values() for first, _ in runs), default=0)
    most = max((last for runs in shifted.values() for _, last in runs), default=-1)
    chosen = _outer(n, [v - centre for v in values if abs(v - centre) > 1], least, most)
    if chosen is None:
        return None
    k, d, q = chosen
    found = 0
    for signed_sum, runs in shifted.items():
        reach = np.abs(signed_sum - d) + q, n - k + q
        for first, last in runs:
            # Only every second number is a possible sum of squares.
            room = np.minimum(reach[1], last) - np.maximum(reach[0], first) + 2
            found += int((np.maximum(room, 0) // 2).sum())
    return found


def without_median(goal: Goal) -> bool:
    """Return whether the solutions of `goal` are not restricted by a median."""
    part = goal.part
    together = part.split.below + 1 == part.split.centre == part.split.above
    return together and part.fewest_below == 0 and part.most_below == goal.n


def _runs(square_sums: list[int]) -> Iterator[tuple[int, int]]:
    """Split numbers into sequences with common difference 2; yield each first and last element."""
    breaks = [i + 1 for i, (a, b) in enumerate(pairwise(square_sums)) if b != a + 2]
    for first, end in pairwise([0, *breaks, len(square_sums)]):
        yield square_sums[first], square_sums[end - 1]


def _outer(
    n: int, distances: list[int], least: int, most: int
) -> tuple[Array, Array, Array] | None:
    """Return k, d and q, as defined in the module docstring, for each combination of outer values.

    Combinations for which the sum of all squared distances cannot lie between `least` and `most`
    are omitted. Returns None if there are too many combinations.
    """
    k = d = q = np.zeros(1, dtype=np.int64)
    far_to_near = sorted(distances, key=abs, reverse=True)
    for x, following in pairwise([*far_to_near, 1]):
        square, rest = x * x, following * following
        top = np.minimum((most - q) // square, n - k)
        # If x occurs f times, the squares of other values add up to at most (n - k - f) * rest.
        lacking = least - q - (n - k) * rest
        if square > rest:
            bottom = np.maximum(-(-lacking // (square - rest)), 0)
        else:
            bottom, top = np.zeros_like(top), np.where(lacking <= 0, top, -1)
        choices = np.maximum(top - bottom + 1, 0)
        total = int(choices.sum())
        if total > CHOICES:
            return None
        before = np.repeat(np.cumsum(choices) - choices - bottom, choices)
        f = np.arange(total) - before
        added = ((k, 1), (d, x), (q, square))
        k, d, q = (np.repeat(part, choices) + f * size for part, size in added)
    return k, d, q
