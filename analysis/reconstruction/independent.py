"""Columns of different participants: t, Welch's t and F over all data sets that are allowed.

With independent groups nothing depends on a pairing: n, sums and sums of squares say it all. The
ranges here are therefore over the pairs of sum and sum of squares that some data set has.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from analysis.reconstruction.comparable_columns import LEVEL
from analysis.reconstruction.conclusions import Conclusion
from faults import UserError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from analysis.reconstruction.solutions import Solutions
    from analysis.reconstruction.state_table import Array

# Pairs of sum and sum of squares that are all set against those of another column; of more, only
# the extremes of each sum are.
ALL_OF = 1000


@dataclass(frozen=True)
class _Group:
    """The means and the variances (n - 1) that one column may have, pair by pair."""

    label: str
    n: int
    mean: Array
    variance: Array
    sharp: bool  # each pair belongs to some data set
    complete: bool  # all pairs are here, not the extremes only


def independent_conclusions(columns: Sequence[Solutions]) -> list[Conclusion]:
    """Return what holds of independent groups in every data set, and what depends on it.

    Raises
    ------
    UserError
        There are fewer than two columns.
    """
    if len(columns) < 2:  # noqa: PLR2004 - one column has nothing to be compared with
        raise UserError("conclusions compare columns: expected two or more in the table")
    groups = [_group(solutions) for solutions in columns]
    found = [test(a, b) for a, b in combinations(groups, 2) for test in (_students_t, _welchs_t)]
    return [*found, _one_way_f(groups)]


def _group(solutions: Solutions) -> _Group:
    column = solutions.column
    pairs, sharp = solutions.attained
    n, step, low = column.n, float(column.scale.step), float(column.scale.minimum)
    complete = len(pairs) <= ALL_OF
    if not complete:
        ends: dict[int, tuple[int, int]] = {}
        for total, squares in pairs:
            least, most = ends.get(total, (squares, squares))
            ends[total] = (min(least, squares), max(most, squares))
        pairs = tuple((total, squares) for total, two in ends.items() for squares in two)
    # Whole numbers, before anything is rounded.
    scatter = np.array([n * q - s * s for s, q in pairs], dtype=np.float64) / n
    sums = np.array([s for s, _ in pairs], dtype=np.float64)
    return _Group(
        label=column.label,
        n=n,
        mean=low + step * sums / n,
        variance=step**2 * scatter / (n - 1),
        sharp=sharp,
        complete=complete,
    )


def _students_t(a: _Group, b: _Group) -> Conclusion:
    degrees = a.n + b.n - 2
    pooled = ((a.n - 1) * a.variance[:, None] + (b.n - 1) * b.variance) / degrees
    t = _ratio(b.mean - a.mean[:, None], np.sqrt(pooled * (1 / a.n + 1 / b.n)))
    words = f"independent t({degrees}) of {b.label} minus {a.label}"
    return _conclusion("student_t", words, (a, b), t, np.full(t.shape, float(degrees)))


def _welchs_t(a: _Group, b: _Group) -> Conclusion:
    of_a, of_b = a.variance[:, None] / a.n, b.variance / b.n
    t = _ratio(b.mean - a.mean[:, None], np.sqrt(of_a + of_b))
    bottom = of_a**2 / (a.n - 1) + of_b**2 / (b.n - 1)
    # Without any variation t is infinite, whatever its degrees of freedom.
    degrees = np.divide((of_a + of_b) ** 2, bottom, out=np.ones_like(t), where=bottom > 0)
    words = f"Welch's t of {b.label} minus {a.label}"
    return _conclusion("welch_t", words, (a, b), t, degrees)


def _conclusion(
    name: str, words: str, groups: tuple[_Group, _Group], t: Array, degrees: Array
) -> Conclusion:
    from scipy.stats import t as student  # noqa: PLC0415 - SciPy takes longer than the counts

    p = 2 * student.sf(np.abs(t), degrees)
    low, high = float(p.min()), float(p.max())
    return Conclusion(
        f"{name}.{groups[0].label}.{groups[1].label}",
        words,
        float(t.min()),
        float(t.max()),
        low,
        high,
        decided=(low < LEVEL) == (high < LEVEL),
        sharp=all(group.sharp and (group.complete or name == "student_t") for group in groups),
    )


def _one_way_f(groups: list[_Group]) -> Conclusion:
    """Return the range of the one-way F; sharp where every column has one sum only."""
    from scipy.stats import f as fisher  # noqa: PLC0415

    k, n = len(groups), sum(group.n for group in groups)
    within = [
        sum((group.n - 1) * pick(group.variance) for group in groups) / (n - k)
        for pick in (np.max, np.min)
    ]
    between = _between(groups, k)
    low, high = (
        float(_ratio(np.array(b), np.array(w))) for b, w in zip(between, within, strict=True)
    )
    ps = [float(fisher.sf(value, k - 1, n - k)) for value in (high, low)]
    one_sum = all(len(np.unique(group.mean)) == 1 for group in groups)
    return Conclusion(
        "one_way_f", f"one-way F({k - 1}, {n - k})", low, high, ps[0], ps[1],
        decided=(ps[0] < LEVEL) == (ps[1] < LEVEL),
        sharp=one_sum and all(group.sharp for group in groups),
    )  # fmt: skip


def _between(groups: list[_Group], k: int) -> tuple[float, float]:
    """Return the least and the largest mean square between groups whose means have ranges.

    The sum of squares is a sum of distances to a common centre, convex in the means: largest at
    ends of the ranges, and least where every mean is as near to the best centre as it can be.
    """
    weights = np.array([group.n for group in groups], dtype=np.float64)
    ends = np.array([(group.mean.min(), group.mean.max()) for group in groups])
    corners = np.array(np.meshgrid(*ends, indexing="ij")).reshape(k, -1)
    centres = weights @ corners / weights.sum()
    largest = float((weights @ (corners - centres) ** 2).max())

    def least_at(centre: float) -> float:
        return float(weights @ (np.clip(centre, ends[:, 0], ends[:, 1]) - centre) ** 2)

    low, high = float(ends.min()), float(ends.max())
    while high - low > 1e-12 * max(abs(high), 1.0):
        first, second = low + (high - low) / 3, high - (high - low) / 3
        low, high = (low, second) if least_at(first) <= least_at(second) else (first, high)
    return least_at(low) / (k - 1), largest / (k - 1)


def _ratio(top: Array, bottom: Array) -> Array:
    """Divide; infinite, or 0 where `top` is 0, without any variation."""
    top, bottom = np.broadcast_arrays(top, bottom)
    out = np.where(top == 0, 0.0, np.copysign(inf, top))
    found: Array = np.divide(top, bottom, out=out, where=bottom > 0)
    return found
