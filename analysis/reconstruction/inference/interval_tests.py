"""Check published tests of columns of continuous values.

Each statistic is a continuous function of means, SDs and, for paired columns, correlations. Within
the intervals that the published numbers allow, the statistic takes every value between its minimum
and its maximum. A published test with a statistic outside this range is impossible. For all other
tests, a search changes the values gradually from the smallest to the largest statistic, until the
statistic agrees with the published test. Every example is checked against the definition of the
statistic. If the search finds no example, the test remains undecided.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, sqrt
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.inference.definitions import STATISTICS
from slipscale.analysis.reconstruction.inference.group_statistics import of_groups, prints
from slipscale.analysis.reconstruction.inference.independent import extreme_between
from slipscale.analysis.reconstruction.inference.printed_test_answer import (
    PAIRED,
    SHOWN,
    UNFOUND,
    PrintedTestAnswer,
    Verdict,
    chosen_columns,
    in_words,
)
from slipscale.analysis.reconstruction.inference.printed_windows import SLACK, fits, windows
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.table.interval_column import IntervalColumn
    from slipscale.analysis.reconstruction.table.printed_tests import PrintedTest

# Settings of the search: points per path, bisections between two points, and number of paths.
PLACES = 60
HALVINGS = 60
PATHS = 10


def answer(test: PrintedTest, columns: Sequence[IntervalColumn]) -> PrintedTestAnswer:
    """Check whether continuous values can reproduce a published test.

    Raises
    ------
    UserError
        If a test of two columns does not name them and the table does not have exactly two columns,
        or if paired columns differ in n.
    """
    chosen = chosen_columns(test, [(c.label, c) for c in columns])
    if test.kind in PAIRED and len({c.n for c in chosen}) > 1:
        raise UserError(
            "test '{kind}': the columns differ in n; expected the same n for pairs", kind=test.kind
        )
    if wrong := next((c for c in chosen if c.reason), None):
        return _said(test, chosen, "impossible", f"column '{wrong.label}': {wrong.reason}")
    extent = _extent(test, chosen)
    allowed = windows(test, [c.n for c in chosen])
    if not any(
        low <= extent[1] * (1 + SLACK) + SLACK and high >= extent[0] * (1 - SLACK) - SLACK
        for low, high in allowed
    ):
        reason = "no possible means, SDs and correlations give the published value"
        return _said(test, chosen, "impossible", reason, extent=extent)
    for seed in range(PATHS):
        for window in allowed:
            shown = _example(test, chosen, window, np.random.default_rng(seed))
            if shown:
                return _said(test, chosen, "possible", SHOWN, extent=extent, example=shown)
    return _said(test, chosen, "not decided", UNFOUND, extent=extent)


def _said(
    test: PrintedTest,
    columns: Sequence[IntervalColumn],
    verdict: Verdict,
    reason: str,
    *,
    extent: tuple[float, float] = (-inf, inf),
    example: Sequence[Array] = (),
) -> PrintedTestAnswer:
    return PrintedTestAnswer(
        kind=test.kind,
        labels=tuple(c.label for c in columns),
        printed=in_words(test),
        verdict=verdict,
        reason=reason,
        low=extent[0],
        high=extent[1],
        example=tuple(
            tuple((np.exp(row) if column.logarithms else row).tolist())
            for column, row in zip(columns, example, strict=False)
        ),
    )


def _extent(test: PrintedTest, columns: Sequence[IntervalColumn]) -> tuple[float, float]:
    """Return bounds on |t|, F or r over all possible means, SDs and correlations."""
    if test.kind == "correlation":
        return -1.0, 1.0
    n = np.array([c.n for c in columns], dtype=float)
    k = len(n)
    means = np.array([c.mean for c in columns])
    (_, least), (_, most) = extreme_between(means, n)
    low, high = np.array([c.sd for c in columns]).T
    if test.kind in PAIRED:
        # Smallest and largest error sum of squares, divided by n - 1: with correlations of 1, and
        # with correlations that are as negative as possible.
        (_, small), _ = extreme_between(np.stack([low, high], axis=1), np.ones(k))
        rest = high.sum() - high.max()
        large = float((high**2).sum()) - max(0.0, float(high.max() - rest)) ** 2 / k
    elif test.kind == "welch_t":
        # The sum of squares between groups is n1 n2 / (n1 + n2) times the squared difference.
        share = n.prod() / n.sum()
        small, large = (float((sd**2 / n).sum() * share) for sd in (low, high))
    else:
        # The sum of squares within groups is scaled so that the sum between groups divided by it is
        # F.
        share = (k - 1) / (n.sum() - k)
        small, large = (float(((n - 1) * sd**2).sum() * share) for sd in (low, high))
    ends = [
        0.0 if top <= 0 else inf if bottom <= 0 else top / bottom
        for top, bottom in ((least, large), (most, small))
    ]
    return (sqrt(ends[0]), sqrt(ends[1])) if test.of_two else (ends[0], ends[1])


def _example(
    test: PrintedTest,
    columns: Sequence[IntervalColumn],
    window: tuple[float, float],
    generator: np.random.Generator,
) -> tuple[Array, ...]:
    path = _Path(test, columns, generator)
    grid = np.linspace(0, 1, PLACES)
    values = np.array([path.value(at) for at in grid])
    middle = window[0] if window[1] == inf else (max(window[0], -inf) + window[1]) / 2
    candidates = [at for at, value in zip(grid, values, strict=True) if path.prints(at, value)]
    for first in np.flatnonzero((values[:-1] - middle) * (values[1:] - middle) <= 0):
        low, high = grid[first], grid[first + 1]
        for _ in range(HALVINGS):
            at = (low + high) / 2
            same = (path.value(at) - middle) * (path.value(low) - middle) > 0
            low, high = (at, high) if same else (low, at)
        if path.prints(high, path.value(high)):
            candidates.append(high)
    for at in candidates:
        rows = path.rows(at)
        if all(
            row.min() >= c.scale[0] and row.max() <= c.scale[1]
            for row, c in zip(rows, columns, strict=True)
        ):
            return tuple(rows)
    return ()


class _Path:
    """Columns that change continuously from the smallest to the largest value of a statistic."""

    def __init__(
        self, test: PrintedTest, columns: Sequence[IntervalColumn], generator: np.random.Generator
    ) -> None:
        self.test, self.columns = test, columns
        self.n = np.array([c.n for c in columns])
        k = len(columns)
        means = np.array([c.mean for c in columns])
        (near, _), (far, _) = extreme_between(means, self.n.astype(float))
        self.means = near, far
        low, high = np.array([c.sd for c in columns]).T
        alike, _ = extreme_between(np.stack([low, high], axis=1), np.ones(k))
        paired = test.kind in PAIRED
        self.sds = high, alike[0] if paired else low
        shapes = [_unit(generator.normal(size=(k + 1, n))) for n in self.n]
        simplex = np.eye(k) - 1 / k
        # Correlations go from -1 / (k - 1) to 1; they do not affect independent groups.
        first = [simplex[j] @ shapes[0 if paired else j][1:] for j in range(k)]
        last = [shapes[0 if paired else j][0] for j in range(k)]
        self.shapes = first, last

    def rows(self, at: float) -> list[Array]:
        """Return the columns at a point of the path, from 0 (smallest statistic) to 1 (largest)."""
        means = self.means[0] + at * (self.means[1] - self.means[0])
        sds = self.sds[0] + at * (self.sds[1] - self.sds[0])
        found = []
        for j, n in enumerate(self.n):
            shape = (1 - at) * self.shapes[0][j] + at * self.shapes[1][j]
            shape = shape / np.sqrt((shape**2).sum() / (n - 1))
            found.append(means[j] + sds[j] * shape)
        return found

    def value(self, at: float) -> float:
        """Return |t|, F or r at a point of the path, or infinity if it is undefined."""
        (value,) = STATISTICS[self.test.kind]([row[None] for row in self.rows(at)])
        if np.isnan(value):
            return inf
        return float(value if self.test.kind == "correlation" else abs(value))

    def prints(self, at: float, value: float) -> bool:
        """Return whether the columns at a point of the path reproduce the published test."""
        if not np.isfinite(value):
            return False
        if self.test.kind in PAIRED:
            return any(
                bool(fits(np.array([value]), window)[0])
                for window in windows(self.test, [c.n for c in self.columns])
            )
        rows = self.rows(at)
        means = np.array([[row.mean() for row in rows]])
        variances = np.array([[row.var(ddof=1) for row in rows]])
        values, p = of_groups(self.test, means, variances, self.n)
        return bool(prints(self.test, values, p, self.n)[0])


def _unit(rows: Array) -> Array:
    """Centre the rows to mean 0, and orthonormalise them if there are more columns than rows."""
    centred = rows - rows.mean(axis=1, keepdims=True)
    if rows.shape[1] > rows.shape[0]:
        centred = np.linalg.qr(centred.T)[0].T
    found: Array = centred - centred.mean(axis=1, keepdims=True)
    return found
