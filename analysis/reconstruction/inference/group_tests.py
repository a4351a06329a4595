"""Check published tests of independent groups, using n, sums and sums of squares."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan

import numpy as np

from slipscale.analysis.reconstruction.counts.state_table import Array
from slipscale.analysis.reconstruction.inference import cross_products
from slipscale.analysis.reconstruction.inference.column_rows import ColumnRows
from slipscale.analysis.reconstruction.inference.counterexamples import impossible, why_not
from slipscale.analysis.reconstruction.inference.group_statistics import of_groups, prints
from slipscale.analysis.reconstruction.inference.independent import (
    group_of,
    moments_of_groups,
    range_of_f,
    students_t,
    welchs_t,
)
from slipscale.analysis.reconstruction.inference.printed_test_answer import (
    SHOWN,
    TOO_MANY,
    UNFOUND,
    Case,
    PrintedTestAnswer,
    Verdict,
)
from slipscale.analysis.reconstruction.inference.printed_windows import SLACK, windows

# Maximum number of combinations of sums and sums of squares that are searched for an example.
SHOWN_FOR = 60


def of_independent_groups(case: Case) -> PrintedTestAnswer:
    """Check a published test of independent groups."""
    rows = [ColumnRows(solutions, sums_first=True) for solutions in case.columns]
    places, complete = cross_products.every_place([len(row.moments) for row in rows])
    means, variances, n = moments_of_groups(rows, places)
    values, p = of_groups(case.test, means, variances, n)
    defined = ~np.isnan(values)
    extent = nan, nan
    if defined.any():
        extent = float(values[defined].min()), float(values[defined].max())
    left = defined & prints(case.test, values, p, n)
    if not complete:
        shown = _shown(rows, places[left]) if left.any() else ()
        return case.said("possible", SHOWN, example=shown) if shown else _outside(case, rows)
    pairs = len(places), int(left.sum())
    if not left.any():
        return impossible(case, rows, why_not(extent), extent, pairs)
    if shown := _shown(rows, places[left]):
        return case.said("possible", SHOWN, extent, pairs=pairs, example=shown)
    # No example was found. Data sets are counted, to exclude sums that do not occur in any of them.
    if any(solutions.not_drawn for solutions in case.columns):
        return case.said("not decided", UNFOUND, extent, pairs=pairs)
    counted = [ColumnRows(solutions) for solutions in case.columns]
    real = [{moments: at for at, moments in enumerate(row.moments)} for row in counted]
    indices = [
        [real[j].get(rows[j].moments[at], -1) for j, at in enumerate(place)]
        for place in places[left].tolist()
    ]
    kept = [place for place in indices if -1 not in place]
    pairs = len(places), len(kept)
    if not kept:
        return impossible(case, counted, why_not(extent), extent, pairs)
    shown = _shown(counted, np.array(kept))
    verdict: Verdict = "possible" if shown else "not decided"
    return case.said(verdict, SHOWN if shown else UNFOUND, extent, pairs=pairs, example=shown)


def _outside(case: Case, rows: Sequence[ColumnRows]) -> PrintedTestAnswer:
    """Check whether a published test lies outside the bounds on its statistic."""
    groups = [group_of(solutions) for solutions in case.columns]
    if case.test.kind == "one_way_f":
        extent = range_of_f(groups)
    else:
        of_kind = students_t if case.test.kind == "independent_t" else welchs_t
        t, _ = of_kind(groups[0], groups[1])
        extent = float(t.min()), float(t.max())
    least = 0.0 if extent[0] <= 0 <= extent[1] else min(map(abs, extent))
    most = max(map(abs, extent))
    if not any(
        low <= most * (1 + SLACK) and high >= least * (1 - SLACK)
        for low, high in windows(case.test, [group.n for group in groups])
    ):
        return impossible(case, rows, why_not(extent), extent)
    return case.said("not decided", TOO_MANY, extent)


def _shown(rows: Sequence[ColumnRows], places: Array) -> tuple[Array, ...]:
    generator = np.random.default_rng(1)
    known: dict[tuple[int, int], Array] = {}
    for place in generator.permutation(places)[:SHOWN_FOR].tolist():
        for j, at in enumerate(place):
            if (j, at) not in known:
                known[j, at] = rows[j].some(at)
        if all(len(known[j, at]) for j, at in enumerate(place)):
            return tuple(known[j, at][0] for j, at in enumerate(place))
    return ()
