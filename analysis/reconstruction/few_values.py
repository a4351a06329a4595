"""Counts for scales of few values, such as Likert's: in closed form but for the outer values.

Take three neighbouring values, c - 1, c and c + 1. Once it is known how often every other value is
there, with k values, a sum d of their distances from c and a sum q of the squared distances, the
three are settled by n, D and V (see `meet_in_the_middle`): w = V - q of the values left lie beside
c, those above less those below are D - d, and all this is possible if and only if
``|D - d| <= w <= n - k``. With the sums of squares in a range of every other number, w ranges, too,
so that each choice of the outer values is worth a subtraction.
"""

from __future__ import annotations

from collections import defaultdict
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from analysis.reconstruction.meet_in_the_middle import Goal
    from analysis.reconstruction.state_table import Array

# Choices of the outer values that are written down; of more, another way of counting is quicker.
CHOICES = 100_000
# Values of a scale beyond which there are more choices in any case.
VALUES = 12


def number(values: Sequence[int], goals: Iterable[Goal]) -> int | None:
    """Return how many multisets of `values`, which ascend, reach one of the goals.

    None where other ways are quicker, or where no three values are neighbours.
    """
    centres = [b for a, b, c in zip(values, values[1:], values[2:], strict=False) if c - a == 2]  # noqa: PLR2004
    if not centres or len(values) > VALUES:
        return None
    found = 0
    for (n, centre), of_sum in _by_sum(centres, goals).items():
        squares = [v for found_there in of_sum.values() for v in found_there]
        outer = [v - centre for v in values if abs(v - centre) > 1]
        chosen = _outer(n, outer, min(squares), max(squares))
        if chosen is None:
            return None
        k, d, q = chosen
        for signed_sum, square_sums in of_sum.items():
            reach = np.abs(signed_sum - d) + q, n - k + q
            for least, most in _runs(sorted(square_sums)):
                # All of a parity, so that rounding down is right.
                room = np.minimum(reach[1], most) - np.maximum(reach[0], least) + 2
                found += int((np.maximum(room, 0) // 2).sum())
    return found


def without_median(goal: Goal) -> bool:
    """Whether a goal's values may lie on either side of the centre, as many as please."""
    part = goal.part
    together = part.split.below + 1 == part.split.centre == part.split.above
    return together and part.fewest_below == 0 and part.most_below == goal.n


def _by_sum(
    centres: Sequence[int], goals: Iterable[Goal]
) -> dict[tuple[int, int], dict[int, list[int]]]:
    """Return, for each n and centre, the sums of squared distances beside each sum of distances."""
    groups: dict[tuple[int, int], dict[int, list[int]]] = defaultdict(lambda: defaultdict(list))
    for goal in goals:
        n, total, squares = goal.n, goal.part.moments.total, goal.part.moments.squares
        # Near the mean the outer values are few.
        centre = min(centres, key=lambda c: abs(c * n - total))
        square_sum = squares - 2 * centre * total + n * centre**2
        groups[n, centre][total - n * centre].append(square_sum)
    return groups


def _runs(square_sums: list[int]) -> Iterator[tuple[int, int]]:
    """Yield the first and the last of every run in steps of two."""
    breaks = [i + 1 for i, (a, b) in enumerate(pairwise(square_sums)) if b != a + 2]
    for first, end in pairwise([0, *breaks, len(square_sums)]):
        yield square_sums[first], square_sums[end - 1]


def _outer(
    n: int, distances: list[int], least: int, most: int
) -> tuple[Array, Array, Array] | None:
    """Return (k, d, q) of all choices of the outer values; None if there are too many.

    Left out are those whose squares exceed `most`, or fall short of `least` whatever follows.
    """
    k = d = q = np.zeros(1, dtype=np.int64)
    far_to_near = sorted(distances, key=abs, reverse=True)
    for x, following in pairwise([*far_to_near, 1]):
        square, rest = x * x, following * following
        top = np.minimum((most - q) // square, n - k)
        # With f of x, the others add at most (n - k - f) * rest.
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
