"""Check published tests of columns from the same participants."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, nan
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.inference import cross_products
from slipscale.analysis.reconstruction.inference.column_rows import ColumnRows
from slipscale.analysis.reconstruction.inference.counterexamples import impossible, why_not
from slipscale.analysis.reconstruction.inference.printed_test_answer import (
    SHOWN,
    TOO_MANY,
    UNFOUND,
    Case,
    PrintedTestAnswer,
)
from slipscale.analysis.reconstruction.inference.printed_windows import SLACK, windows

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.inference.cross_products import Choices
    from slipscale.analysis.reconstruction.table.printed_tests import PrintedTest


def of_pairs(case: Case) -> PrintedTestAnswer:
    """Check a published test of paired columns, using the possible sums of cross products."""
    rows = [ColumnRows.quickest(solutions) for solutions in case.columns]
    empty = next((row for row in rows if not row.moments), None)
    if empty is not None:
        label = empty.solutions.column.label
        return case.said("impossible", f"no ratings give the published column '{label}'")
    found = cross_products.choices(rows)
    extent = _extent(case.test, found) if found.complete else (-inf, inf)
    parts = _wanted(case.test, found)
    left = np.any([low <= high for low, high in parts], axis=0) if parts else np.zeros(0, bool)
    pairs = (len(found.places), int(left.sum())) if found.complete else None
    if not left.any():
        if not found.complete:
            return case.said("not decided", TOO_MANY)
        return impossible(case, rows, why_not(extent), extent, pairs)
    generator = np.random.default_rng(1)
    shown: tuple[Array, ...] | None = ()
    for part in parts:
        shown = cross_products.example(rows, found, part, generator)
        if not shown and found.complete:
            shown = cross_products.every(rows, found, part)
        if shown or shown is None:
            break
    if shown == () and found.complete:
        reason = "all pairings of all data sets were tried, and none gives the published value"
        return impossible(case, rows, reason, extent, pairs)
    correlation = _correlations(found, parts) if case.test.of_two else None
    return case.said(
        "possible" if shown else "not decided",
        SHOWN if shown else UNFOUND,
        extent,
        pairs=pairs,
        correlation=correlation,
        example=shown or (),
    )


def _wanted(test: PrintedTest, found: Choices) -> list[tuple[Array, Array]]:
    """Return the sums of cross products that reproduce the published test.

    Each list entry contains the smallest and the largest acceptable sum for each combination in
    `found`.
    """
    n, k = found.n, found.sums.shape[1]
    allowed = windows(test, [n] * k)
    if test.kind == "correlation":
        reach = _reach(found)
        middle = found.sums.prod(axis=1)
        slack = SLACK * (1 + reach)
        return [
            _whole(
                np.where(reach > 0, (low * reach + middle - slack) / n, inf),
                np.where(reach > 0, (high * reach + middle + slack) / n, -inf),
                found,
            )
            for low, high in allowed
        ]
    if not allowed:
        return []
    # For two columns, F is t².
    power = 2 if test.kind == "paired_t" else 1
    low, high = (value**power for value in allowed[0])
    top = (n - 1) * found.between.astype(float)
    # The statistic is undefined if the error sum of squares is 0. Multiplied by n k, this sum is a
    # whole number, so it must be at least 1.
    with np.errstate(divide="ignore", invalid="ignore"):
        most = np.where(top > 0, top / low if low > 0 else inf, inf if low <= SLACK else -inf)
        least = top / high if high > 0 else np.where(top > 0, inf, 0.0)
    least = np.maximum(least * (1 - SLACK) ** 2 - SLACK, 1.0)
    base = found.error(np.zeros(len(top), np.int64)).astype(float)
    return [_whole((base - most * (1 + SLACK) ** 2) / (2 * n), (base - least) / (2 * n), found)]


def _whole(low: Array, high: Array, found: Choices) -> tuple[Array, Array]:
    """Return the smallest and the largest possible sum of cross products in an interval."""
    least, most = found.least.astype(float), found.most.astype(float)
    low, high = np.maximum(np.ceil(low - 1e-9), least), np.minimum(np.floor(high + 1e-9), most)
    none = low > high
    low[none], high[none] = 1, 0
    return low.astype(np.int64), high.astype(np.int64)


def _reach(found: Choices) -> Array:
    """Return the Cauchy-Schwarz bound on n times the sum of products of deviations."""
    spread = np.maximum(found.n * found.squares - found.sums**2, 0).astype(float)
    found_reach: Array = np.sqrt(spread.prod(axis=1))
    return found_reach


def _extent(test: PrintedTest, found: Choices) -> tuple[float, float]:
    """Return bounds on the statistic over all pairings, or NaN if it is always undefined."""
    if test.kind == "correlation":
        reach = _reach(found)
        defined = reach > 0
        if not defined.any():
            return nan, nan
        middle = found.sums.prod(axis=1)
        ends = [(found.n * c - middle)[defined] / reach[defined] for c in (found.least, found.most)]
        return max(-1.0, float(ends[0].min())), min(1.0, float(ends[1].max()))
    top = (found.n - 1) * found.between.astype(float)
    largest, smallest = found.error(found.least), found.error(found.most)
    defined = largest > 0
    if not defined.any():
        return nan, nan
    top, largest, smallest = top[defined], largest[defined], smallest[defined]
    low = top / largest
    # F is undefined if the error is 0. Multiplied by n k, the smallest possible positive error is
    # 1.
    high = top / np.maximum(smallest, 1)
    if test.kind == "rm_f":
        return float(low.min()), float(high.max())
    rises = np.sign(found.sums[:, 1] - found.sums[:, 0])[defined]
    ts = np.concatenate([rises * np.sqrt(low), rises * np.sqrt(high)])
    return float(ts.min()), float(ts.max())


def _correlations(
    found: Choices, parts: Sequence[tuple[Array, Array]]
) -> tuple[float, float] | None:
    reach, middle = _reach(found), found.sums.prod(axis=1)
    ends = [
        (found.n * c - middle)[usable] / reach[usable]
        for low, high in parts
        for usable in [(low <= high) & (reach > 0)]
        for c in (low, high)
    ]
    every = np.concatenate(ends) if ends else np.zeros(0)
    return (float(every.min()), float(every.max())) if len(every) else None
