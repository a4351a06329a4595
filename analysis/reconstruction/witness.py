"""One data set that a column allows, where all of them are too many to count.

Found by moving ratings in pairs, as SPRITE does (Heathers et al., 2018), and checked from the
definitions, so that a column with a witness has a data set, whatever the search did.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import islice
from math import sqrt
from random import Random
from statistics import NormalDist
from typing import TYPE_CHECKING

from analysis.reconstruction.partition import partition

if TYPE_CHECKING:
    from collections.abc import Sequence

    from analysis.reconstruction.constraints import Targets
    from analysis.reconstruction.partition import Part
    from analysis.reconstruction.published_table import Column

# Sums of squares, and parts of each, that are tried; and moves in each.
TRIED = 8
MOVES = 200_000
# Share of moves that lead away: the way out of a dead end.
ASTRAY = 0.01


def witness(column: Column, targets: Targets) -> tuple[int, ...]:
    """Return ratings that give every printed number, in steps above the minimum; empty if none.

    None found does not mean that there is none.
    """
    wanted = targets.wanted or targets.looked_at
    middle = len(wanted) // 2
    for wish in wanted[middle : middle + TRIED]:
        for part in islice(partition(wish), TRIED):
            found = _free_values(part)
            given = [value for value, times in part.given for _ in range(times)]
            values = tuple(sorted([*found, *given]))
            if len(values) == column.n and gives_what_is_printed(column, values):
                return values
    return ()


def gives_what_is_printed(column: Column, steps: Sequence[int]) -> bool:
    """Whether ratings, in steps above the minimum, give every printed number: the definitions."""
    x = sorted(column.scale.value(v) for v in steps)
    n, rule = column.n, column.rounding
    if len(x) != n or min(steps) < 0 or max(steps) > column.scale.steps:
        return False
    mean = sum(x) / Fraction(n)
    variance = sum((v - mean) ** 2 for v in x) / (n - (column.sd_convention == "sample"))
    sd = column.sd.values(rule)
    above = sd.low < 0 or variance > sd.low**2 or (sd.low_closed and variance == sd.low**2)
    below = variance < sd.high**2 or (sd.high_closed and variance == sd.high**2)
    facts = (
        (column.mean, mean),
        (column.maximum_deviation, max(x[-1] - mean, mean - x[0])),
        (column.observed_minimum, x[0]),
        (column.observed_maximum, x[-1]),
        (column.median, (x[(n - 1) // 2] + x[n // 2]) / 2),
    )
    return above and below and all(p is None or value in p.values(rule) for p, value in facts)


def _free_values(part: Part) -> list[int]:
    """Return free values with the moments of a part, as far as the search gets."""
    n, total, squares = part.moments.n, part.moments.total, part.moments.squares
    low, high = part.split.low, part.split.high
    if n == 0:
        return []
    # Like a normal distribution of the right mean and SD, rounded: near enough to begin with.
    normal = NormalDist(total / n, max(sqrt(max(squares / n - (total / n) ** 2, 0.0)), 1e-9))
    x = [min(max(round(normal.inv_cdf((i + 0.5) / n)), low), high) for i in range(n)]
    random = Random(1)
    _reach_total(x, total, low, high, random)
    missing = squares - sum(v * v for v in x)
    for _ in range(MOVES):
        if not missing:
            break
        i, j = random.randrange(n), random.randrange(n)
        # x[i] down and x[j] up keeps the sum.
        if i == j or x[i] == low or x[j] == high:
            continue
        gain = 2 * (x[j] - x[i]) + 2
        if abs(missing - gain) < abs(missing) or random.random() < ASTRAY:
            x[i] -= 1
            x[j] += 1
            missing -= gain
    return x


def _reach_total(x: list[int], total: int, low: int, high: int, random: Random) -> None:
    """Move single values, by one step each, until they have this sum, as far as they can."""
    missing = total - sum(x)
    for _ in range(MOVES):
        if not missing:
            return
        step = 1 if missing > 0 else -1
        i = random.randrange(len(x))
        if low <= x[i] + step <= high:
            x[i] += step
            missing -= step
