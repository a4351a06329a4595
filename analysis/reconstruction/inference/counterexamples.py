"""Check the verdict "impossible" by searching for ratings that reproduce the published test.

The search uses only the definitions of the statistics, so it is independent of the derivation that
led to the verdict.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.inference.definitions import STATISTICS
from slipscale.analysis.reconstruction.inference.group_statistics import of_groups, prints
from slipscale.analysis.reconstruction.inference.printed_test_answer import (
    PAIRED,
    SHOWN,
    Case,
    PrintedTestAnswer,
)
from slipscale.analysis.reconstruction.inference.printed_windows import fits, windows

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.inference.column_rows import ColumnRows
    from slipscale.analysis.reconstruction.table.printed_tests import PrintedTest

# Number of tables to search per kind of pairing, and number of choices of moments per column.
ATTACKED = 500
SHOWN_FOR = 60


def impossible(
    case: Case,
    rows: Sequence[ColumnRows],
    reason: str,
    extent: tuple[float, float],
    pairs: tuple[int, int] | None = None,
) -> PrintedTestAnswer:
    """Return the verdict "impossible", unless a search finds ratings that reproduce the test."""
    shown = _counterexample(case.test, rows)
    if shown:
        return case.said("possible", SHOWN, extent, pairs=pairs, example=shown)
    return case.said("impossible", reason, extent, pairs=pairs)


def why_not(extent: tuple[float, float]) -> str:
    """Explain why a test is impossible, given the bounds on its statistic (NaN if undefined)."""
    if isnan(extent[0]):
        return "the statistic is undefined for every data set, because its denominator is zero"
    return "no possible sums, sums of squares and sums of products give the published value"


def _counterexample(test: PrintedTest, rows: Sequence[ColumnRows]) -> tuple[Array, ...]:
    generator = np.random.default_rng(2)
    tables = []
    for row in rows:
        places = generator.integers(len(row.moments), size=min(len(row.moments), SHOWN_FOR))
        known = [part for place in set(places.tolist()) if len(part := row.some(place))]
        if not known:
            return ()
        pool = np.concatenate(known)
        tables.append(pool[generator.integers(len(pool), size=ATTACKED)].astype(float))
    pairings = [tables]
    if test.kind in PAIRED:
        pairings += [
            [tables[0], *(row[:, ::-1] for row in tables[1:])],
            [generator.permuted(row, axis=1) for row in tables],
        ]
    sizes = np.array([row.n for row in rows])
    for columns in pairings:
        values = STATISTICS[test.kind](columns)
        hit = np.flatnonzero(_prints_by_definition(test, values, columns, sizes))
        if len(hit):
            return tuple(column[hit[0]].astype(np.int64) for column in columns)
    return ()


def _prints_by_definition(
    test: PrintedTest, values: Array, columns: Sequence[Array], n: Array
) -> Array:
    """Return a mask of values that match the published test. Undefined values (NaN) never match."""
    defined = ~np.isnan(values)
    if test.kind in PAIRED:
        size = values if test.kind == "correlation" else np.abs(values)
        hit = np.zeros(len(values), dtype=bool)
        for window in windows(test, n.tolist()):
            hit |= fits(size, window)
        return defined & hit
    means = np.stack([x.mean(axis=1) for x in columns], axis=1)
    variances = np.stack([x.var(axis=1, ddof=1) for x in columns], axis=1)
    return defined & prints(test, values, of_groups(test, means, variances, n)[1], n)
