"""Find one data set consistent with a column that has too many data sets to count.

Ratings are given as numbers of scale steps above the minimum of the scale.

The search changes pairs of ratings, as in SPRITE (Heathers et al., 2018). A data set is returned
only if its statistics, computed from their definitions, match the published numbers. A data set
that is returned therefore proves that the published numbers are possible.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import islice
from math import sqrt
from random import Random
from statistics import NormalDist
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.counts.partition import Part, Wanted, partition
from slipscale.analysis.reconstruction.table.quartiles import are_met

if TYPE_CHECKING:
    from slipscale.analysis.published.printed_numbers import Printed
    from slipscale.analysis.reconstruction.data_sets.constraints import Targets
    from slipscale.analysis.reconstruction.table.published_table import Column

# Maximum number of pairs of sum and sum of squares to try, and of parts to try per pair.
TRIED = 8
# Maximum number of moves (changes of two ratings) per part, in full and in quick searches.
MOVES = 200_000
QUICK = 5_000
# Probability of accepting a move that does not reduce the distance from the target.
ASTRAY = 0.01


def witness(column: Column, targets: Targets) -> tuple[int, ...]:
    """Search for ratings that match all published numbers of a column.

    Returns an empty tuple if no ratings are found, which does not prove that none exist.
    """
    wanted = targets.wanted or targets.looked_at
    middle = len(wanted) // 2
    for wish in wanted[middle : middle + TRIED]:
        if values := _of_wish(column, wish, MOVES):
            return values
    return ()


def witness_of(column: Column, targets: Targets, moments: tuple[int, int]) -> tuple[int, ...]:
    """Search for ratings with the given moments that match all published numbers of a column.

    Returns an empty tuple if no ratings are found. The search is shorter than in `witness`, because
    it is repeated for many pairs of sum and sum of squares.
    """
    wishes = [w for w in targets.wanted if (w.moments.total, w.moments.squares) == moments]
    return next((found for wish in wishes if (found := _of_wish(column, wish, QUICK))), ())


def _of_wish(column: Column, wish: Wanted, moves: int) -> tuple[int, ...]:
    for part in islice(partition([wish]), TRIED):
        found = _free_values(part, moves)
        given = [value for value, times in part.given for _ in range(times)]
        values = tuple(sorted([*found, *given]))
        if len(values) == column.n and gives_what_is_printed(column, values):
            return values
    return ()


def gives_what_is_printed(column: Column, steps: Sequence[int]) -> bool:
    """Return whether ratings match all published numbers of a column."""
    x = sorted(column.scale.value(v) for v in steps)
    n, rule = column.n, column.rounding
    if len(x) != n or min(steps) < 0 or max(steps) > column.scale.steps:
        return False
    mean = sum(x) / Fraction(n)
    degrees = n - (column.sd_convention == "sample")
    variance = sum((v - mean) ** 2 for v in x) / Fraction(degrees)
    facts = (
        *((printed, mean * factor) for printed, factor in column.means()),
        (column.maximum_deviation, max(x[-1] - mean, mean - x[0])),
        (column.observed_minimum, x[0]),
        (column.observed_maximum, x[-1]),
        (column.median, (x[(n - 1) // 2] + x[n // 2]) / 2),
        *((printed, Fraction(100 * x.count(v), n)) for v, printed in column.percentages),
    )
    roots = ((column.sd, variance), (column.se, variance / n))
    return (
        all(p is None or value in p.values(rule) for p, value in facts)
        and all(p is None or _prints_root(p, value, rule) for p, value in roots)
        and _prints_interval(column, mean, variance)
        and all(x.count(v) == times for v, times in column.frequencies)
        and all(v in x for v in column.present)
        and not any(v in x for v in column.absent)
        and bool(are_met(column, np.array([sorted(steps)]))[0])
    )


def _prints_root(printed: Printed, square: Fraction, rule: str) -> bool:
    root = printed.values(rule)
    above = root.low < 0 or square > root.low**2 or (root.low_closed and square == root.low**2)
    return above and (square < root.high**2 or (root.high_closed and square == root.high**2))


def _prints_interval(column: Column, mean: Fraction, variance: Fraction) -> bool:
    if column.ci_low is None or column.ci_high is None:
        return True
    half = Fraction(column.quantile * sqrt(variance / column.n))
    slack = half / 10**9
    return all(
        end.values(column.rounding).low - slack <= value <= end.values(column.rounding).high + slack
        for end, value in ((column.ci_low, mean - half), (column.ci_high, mean + half))
    )


def _free_values(part: Part, moves: int) -> list[int]:
    """Search for free values with the number, sum and sum of squares that a part requires.

    If the search fails, the sum or the sum of squares of the returned values is not the required
    one.
    """
    n, total, squares = part.moments.n, part.moments.total, part.moments.squares
    low, high = part.split.low, part.split.high
    if n == 0:
        return []
    holes = part.split.holes
    # Start from a rounded normal distribution with the required mean and SD.
    normal = NormalDist(total / n, max(sqrt(max(squares / n - (total / n) ** 2, 0.0)), 1e-9))
    free = [v for v in range(low, high + 1) if v not in holes] if holes else range(low, high + 1)
    if not free:
        return []
    x = [min(max(round(normal.inv_cdf((i + 0.5) / n)), low), high) for i in range(n)]
    if holes:
        x = [min(free, key=lambda f, v=v: abs(f - v)) for v in x]
    random = Random(1)
    _reach_total(x, total, part, random, moves)
    missing = squares - sum(v * v for v in x)
    for _ in range(moves):
        if not missing:
            break
        i, j = random.randrange(n), random.randrange(n)
        # Decreasing x[i] and increasing x[j] by the same amount preserves the sum.
        if i == j or x[i] == low or x[j] == high or x[i] - 1 in holes or x[j] + 1 in holes:
            continue
        gain = 2 * (x[j] - x[i]) + 2
        if abs(missing - gain) < abs(missing) or random.random() < ASTRAY:
            x[i] -= 1
            x[j] += 1
            missing -= gain
    return x


def _reach_total(x: list[int], total: int, part: Part, random: Random, moves: int) -> None:
    """Change values by one step at a time, until their sum is `total` or after `moves` attempts."""
    missing = total - sum(x)
    for _ in range(moves):
        if not missing:
            return
        step = 1 if missing > 0 else -1
        i = random.randrange(len(x))
        if part.split.low <= x[i] + step <= part.split.high and x[i] + step not in part.split.holes:
            x[i] += step
            missing -= step
