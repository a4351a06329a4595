"""Compute t, Welch's t and F for columns from different participants, over all data sets.

Statistics of independent groups depend only on n, sums and sums of squares. The range of a
statistic therefore covers all pairs of sum and sum of squares that occur in a data set or, if
counting data sets is slow, all pairs that the published numbers allow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.inference.column_rows import ColumnRows
from slipscale.analysis.reconstruction.inference.comparable_columns import LEVEL
from slipscale.analysis.reconstruction.inference.conclusions import Conclusion
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
    from slipscale.analysis.reconstruction.table.published_table import Column

# If a column has more pairs of sum and sum of squares, only the smallest and largest sum of squares
# for each sum are compared.
ALL_OF = 1000


@dataclass(frozen=True)
class Group:
    """Possible means and variances (with divisor n - 1) of one column."""

    label: str
    n: int
    mean: Array
    variance: Array
    sharp: bool  # whether every mean and variance occurs in a data set
    complete: bool  # whether all means and variances are included


def independent_conclusions(columns: Sequence[Solutions]) -> list[Conclusion]:
    """Return all conclusions about independent groups.

    Raises
    ------
    UserError
        If there are fewer than two columns.
    """
    if len(columns) < 2:  # noqa: PLR2004 - one column has nothing to be compared with
        raise UserError("conclusions compare columns: expected two or more columns")
    groups = [group_of(solutions) for solutions in columns]
    found = [test(a, b) for a, b in combinations(groups, 2) for test in (_students_t, _welchs_t)]
    return [*found, _one_way_f(groups)]


def group_of(solutions: Solutions) -> Group:
    """Return the possible means and variances of a column.

    If counting data sets is slow, the means and variances are derived from the published numbers
    alone, and some of them may not occur in any data set.
    """
    column, rows = solutions.column, ColumnRows.quickest(solutions)
    pairs, sharp = rows.moments, not rows.sums_first
    complete = len(pairs) <= ALL_OF
    if not complete:
        ends: dict[int, tuple[int, int]] = {}
        for total, squares in pairs:
            least, most = ends.get(total, (squares, squares))
            ends[total] = (min(least, squares), max(most, squares))
        pairs = tuple((total, squares) for total, two in ends.items() for squares in two)
    mean, variance = _means_and_variances(column, pairs)
    return Group(
        label=column.label,
        n=column.n,
        mean=mean,
        variance=variance,
        sharp=sharp,
        complete=complete,
    )


def moments_of_groups(rows: Sequence[ColumnRows], places: Array) -> tuple[Array, Array, Array]:
    """Return means and variances (n - 1), both of shape (choices, groups), and each group's n.

    Parameters
    ----------
    rows : sequence of ColumnRows
        The groups.
    places : ndarray of int, shape (choices, groups)
        For each group, the index of its sum and sum of squares in `ColumnRows.moments`.
    """
    found = [
        _means_and_variances(row.solutions.column, row.moments)[:, places[:, j]]
        for j, row in enumerate(rows)
    ]
    means, variances = np.stack(found, axis=2)
    return means, variances, np.array([row.n for row in rows])


def _means_and_variances(column: Column, pairs: Sequence[tuple[int, int]]) -> Array:
    """Convert pairs of sum and sum of squares to means and variances (n - 1), shape (2, pairs)."""
    n, step, low = column.n, float(column.scale.step), float(column.scale.minimum)
    # Computed in whole numbers, to avoid rounding errors.
    scatter = np.array([n * q - s * s for s, q in pairs], dtype=np.float64) / n
    sums = np.array([s for s, _ in pairs], dtype=np.float64)
    return np.array([low + step * sums / n, step**2 * scatter / (n - 1)])


def students_t(a: Group, b: Group) -> tuple[Array, Array]:
    """Return Student's t for b minus a, and its degrees of freedom.

    Rows are the possible means and variances of `a`, and columns are those of `b`.
    """
    degrees = a.n + b.n - 2
    pooled = ((a.n - 1) * a.variance[:, None] + (b.n - 1) * b.variance) / degrees
    t = _ratio(b.mean - a.mean[:, None], np.sqrt(pooled * (1 / a.n + 1 / b.n)))
    return t, np.full(t.shape, float(degrees))


def welchs_t(a: Group, b: Group) -> tuple[Array, Array]:
    """Return Welch's t for b minus a, and its degrees of freedom.

    Rows are the possible means and variances of `a`, and columns are those of `b`.
    """
    of_a, of_b = a.variance[:, None] / a.n, b.variance / b.n
    t = _ratio(b.mean - a.mean[:, None], np.sqrt(of_a + of_b))
    bottom = of_a**2 / (a.n - 1) + of_b**2 / (b.n - 1)
    # Without variation, t is infinite, whatever the degrees of freedom.
    return t, np.divide((of_a + of_b) ** 2, bottom, out=np.ones_like(t), where=bottom > 0)


def _students_t(a: Group, b: Group) -> Conclusion:
    words = f"independent-samples t({a.n + b.n - 2}) of {b.label} minus {a.label}"
    return _conclusion("student_t", words, (a, b), *students_t(a, b))


def _welchs_t(a: Group, b: Group) -> Conclusion:
    words = f"Welch's t of {b.label} minus {a.label}"
    return _conclusion("welch_t", words, (a, b), *welchs_t(a, b))


def _conclusion(
    name: str, words: str, groups: tuple[Group, Group], t: Array, degrees: Array
) -> Conclusion:
    from scipy.stats import t as student

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


def range_of_f(groups: Sequence[Group]) -> tuple[float, float]:
    """Return a lower and an upper bound on the one-way F."""
    k, n = len(groups), sum(group.n for group in groups)
    within = [
        sum((group.n - 1) * pick(group.variance) for group in groups) / (n - k)
        for pick in (np.max, np.min)
    ]
    ends = np.array([(group.mean.min(), group.mean.max()) for group in groups])
    weights = np.array([group.n for group in groups], dtype=np.float64)
    between = [value / (k - 1) for _, value in extreme_between(ends, weights)]
    low, high = (
        float(_ratio(np.array(b), np.array(w))) for b, w in zip(between, within, strict=True)
    )
    return low, high


def _one_way_f(groups: Sequence[Group]) -> Conclusion:
    from scipy.stats import f as fisher

    k, n = len(groups), sum(group.n for group in groups)
    low, high = range_of_f(groups)
    ps = [float(fisher.sf(value, k - 1, n - k)) for value in (high, low)]
    one_sum = all(len(np.unique(group.mean)) == 1 for group in groups)
    return Conclusion(
        "one_way_f", f"one-way F({k - 1}, {n - k})", low, high, ps[0], ps[1],
        decided=(ps[0] < LEVEL) == (ps[1] < LEVEL),
        sharp=one_sum and all(group.sharp for group in groups),
    )  # fmt: skip


def extreme_between(ends: Array, weights: Array) -> tuple[tuple[Array, float], tuple[Array, float]]:
    """Choose the group means with the smallest and the largest weighted variance.

    The weighted sum of squared distances from the weighted mean is a convex function of the means.
    It is largest if every mean is at an end of its range, and smallest if every mean is as close to
    a common centre as possible.

    Parameters
    ----------
    ends : ndarray, shape (groups, 2)
        Range of each mean.
    weights : ndarray, shape (groups,)
        Number of participants in each group.

    Returns
    -------
    smallest : tuple of (ndarray, float)
        Means with the smallest weighted variance, and their weighted sum of squared deviations.
    largest : tuple of (ndarray, float)
        Means with the largest weighted variance, and their weighted sum of squared deviations.
    """
    corners = np.array(np.meshgrid(*ends, indexing="ij")).reshape(len(ends), -1)
    centres = weights @ corners / weights.sum()
    sums = weights @ (corners - centres) ** 2
    at = int(sums.argmax())

    def nearest(centre: float) -> Array:
        found: Array = np.clip(centre, ends[:, 0], ends[:, 1])
        return found

    def least_at(centre: float) -> float:
        return float(weights @ (nearest(centre) - centre) ** 2)

    low, high = float(ends.min()), float(ends.max())
    while high - low > 1e-12 * max(abs(high), 1.0):
        first, second = low + (high - low) / 3, high - (high - low) / 3
        low, high = (low, second) if least_at(first) <= least_at(second) else (first, high)
    return (nearest(low), least_at(low)), (corners[:, at], float(sums[at]))


def _ratio(top: Array, bottom: Array) -> Array:
    """Divide `top` by `bottom`. If `bottom` is 0, return infinity, or 0 if `top` is also 0."""
    top, bottom = np.broadcast_arrays(top, bottom)
    out = np.where(top == 0, 0.0, np.copysign(inf, top))
    found: Array = np.divide(top, bottom, out=out, where=bottom > 0)
    return found
