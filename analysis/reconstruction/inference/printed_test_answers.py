"""Whether tests printed beside a table can come from the data sets that the table allows.

Of independent groups n, sums and sums of squares decide. Of the same participants the sum of cross
products decides, too, which the pairing leaves open (`cross_products`).

Rules:

- *Impossible* means: no choice of sums, sums of squares and, for pairs, cross products prints the
  test, and a search by the definitions (`definitions`) finds no counterexample either.
- *Possible* means: a table of ratings that prints the test is shown. It was found by a search and
  its statistic was computed from the definition.
- Anything else is *not decided*.
- A statistic that is not defined (t of equal differences, F or t without variation within groups,
  r of a constant column) is never printed.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, nan, sqrt
from typing import TYPE_CHECKING, Literal

import numpy as np

from slipscale.analysis.reconstruction.inference import cross_products
from slipscale.analysis.reconstruction.inference.column_rows import ColumnRows
from slipscale.analysis.reconstruction.inference.comparable_columns import (
    require_comparable,
    values_of,
)
from slipscale.analysis.reconstruction.inference.definitions import STATISTICS
from slipscale.analysis.reconstruction.inference.independent import (
    group_of,
    moments_of_groups,
    range_of_f,
    students_t,
    welchs_t,
)
from slipscale.analysis.reconstruction.inference.printed_windows import (
    SLACK,
    f_window,
    fits,
    p_between,
    r_windows,
    size_of,
    t_window,
)
from slipscale.faults import UserError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
    from slipscale.analysis.reconstruction.inference.conclusions import Ratings
    from slipscale.analysis.reconstruction.inference.cross_products import Choices
    from slipscale.analysis.reconstruction.table.printed_tests import PrintedTest

Verdict = Literal["possible", "impossible", "not decided"]
WORDS = {
    "paired_t": "paired t",
    "independent_t": "independent t",
    "welch_t": "Welch's t",
    "one_way_f": "one-way F",
    "rm_f": "repeated-measures F",
    "correlation": "correlation",
}
PAIRED = ("paired_t", "correlation", "rm_f")
# Tables that a counterexample is sought among.
ATTACKED = 500
# Choices of moments that examples are sought for.
SHOWN_FOR = 60


@dataclass(frozen=True, kw_only=True)
class PrintedTestAnswer:
    """What is known of a printed test.

    Parameters
    ----------
    kind : str
        Of the test.
    labels : tuple of str
        The columns that it compares.
    printed : str
        What is printed of it, in words.
    verdict : {"possible", "impossible", "not decided"}
        Whether some data set and pairing print it.
    reason : str
        Why, in a sentence.
    low, high : float
        Bounds of the statistic over all data sets and pairings; not every value between them
        occurs. `high` is infinite if nothing bounds it; both are NaN if it is never defined.
    pairs, pairs_left : int or None
        How many choices of a sum and a sum of squares for each column there are, and with how many
        the test can be printed; None if they are not examined one by one.
    correlation_low, correlation_high : float or None
        The correlation that the printed test leaves; None for independent groups.
    example : tuple of tuple of float
        Ratings that print the test, one row per column; empty if none are known.
    """

    kind: str
    labels: tuple[str, ...]
    printed: str
    verdict: Verdict
    reason: str
    low: float
    high: float
    pairs: int | None = None
    pairs_left: int | None = None
    correlation_low: float | None = None
    correlation_high: float | None = None
    example: Ratings = ()

    @property
    def question(self) -> str:
        """The test in words."""
        return f"{WORDS[self.kind]} of {', '.join(self.labels)}"


@dataclass(frozen=True)
class _Case:
    """A test and the columns that it compares."""

    test: PrintedTest
    columns: tuple[Solutions, ...]

    def said(
        self,
        verdict: Verdict,
        reason: str,
        extent: tuple[float, float] = (-inf, inf),
        *,
        pairs: tuple[int, int] | None = None,
        correlation: tuple[float, float] | None = None,
        example: Sequence[Array] = (),
    ) -> PrintedTestAnswer:
        """Return an answer; an example is given in steps, one row per column."""
        return PrintedTestAnswer(
            kind=self.test.kind,
            labels=tuple(s.column.label for s in self.columns),
            printed=in_words(self.test),
            verdict=verdict,
            reason=reason,
            low=extent[0],
            high=extent[1],
            pairs=pairs and pairs[0],
            pairs_left=pairs and pairs[1],
            correlation_low=correlation and correlation[0],
            correlation_high=correlation and correlation[1],
            example=tuple(
                tuple(float(v) for v in values_of(solutions, row))
                for solutions, row in zip(self.columns, example, strict=False)
            ),
        )

    def impossible(
        self,
        rows: Sequence[ColumnRows],
        reason: str,
        extent: tuple[float, float],
        pairs: tuple[int, int] | None = None,
    ) -> PrintedTestAnswer:
        """Return "impossible" unless a search by the definitions finds that it is not."""
        shown = _counterexample(self.test, rows)
        if shown:
            return self.said("possible", SHOWN, extent, pairs=pairs, example=shown)
        return self.said("impossible", reason, extent, pairs=pairs)


SHOWN = "the ratings below print it"
TOO_MANY = "too many sums and sums of squares print the columns to examine all of them"
UNFOUND = "its bounds allow it, but no ratings that print it were found"


def answer(test: PrintedTest, columns: Sequence[Solutions]) -> PrintedTestAnswer:
    """Return what is known of a printed test.

    Raises
    ------
    UserError
        It compares two columns, and there are more, or columns that cannot be compared.
    """
    chosen = [s for s in columns if not test.columns or s.column.label in test.columns]
    if test.columns:
        chosen.sort(key=lambda s: test.columns.index(s.column.label))
    if test.of_two and len(chosen) != 2:  # noqa: PLR2004 - a pair
        raise UserError(f"test '{test.kind}': expected the labels of its two columns")
    if test.kind in PAIRED:
        require_comparable(chosen)
    case = _Case(test, tuple(chosen))
    for solutions in chosen:
        if solutions.targets.refused:
            return case.said("not decided", solutions.targets.refused)
        if not solutions.targets.wanted:
            label = solutions.column.label
            return case.said("impossible", f"no ratings print column '{label}'")
    return _paired(case) if test.kind in PAIRED else _independent(case)


def in_words(test: PrintedTest) -> str:
    """Return what is printed of a test.

    >>> from slipscale.analysis.reconstruction.table.printed_tests import PrintedTest
    >>> in_words(PrintedTest(kind="paired_t", statistic="2.31", p_below=".05", sides=1))
    't = 2.31, one-sided p < .05'
    """
    sign = {"correlation": "r", "one_way_f": "F", "rm_f": "F"}.get(test.kind, "t")
    p = "p" if test.sides == 2 else "one-sided p"  # noqa: PLR2004 - both sides
    parts = (
        (sign, " = ", test.statistic),
        (p, " = ", test.p),
        (p, " < ", test.p_below),
        ("d", " = ", test.d),
        ("partial η²", " = ", test.partial_eta_squared),
    )
    return ", ".join(f"{name}{how}{text.text}" for name, how, text in parts if text is not None)


def _paired(case: _Case) -> PrintedTestAnswer:
    """Answer from the sum of cross products that each choice of moments leaves open."""
    rows = [ColumnRows.quickest(solutions) for solutions in case.columns]
    empty = next((row for row in rows if not row.moments), None)
    if empty is not None:
        label = empty.solutions.column.label
        return case.said("impossible", f"no ratings print column '{label}'")
    found = cross_products.choices(rows)
    extent = _extent(case.test, found) if found.complete else (-inf, inf)
    parts = _wanted(case.test, found)
    left = np.any([low <= high for low, high in parts], axis=0) if parts else np.zeros(0, bool)
    pairs = (len(found.places), int(left.sum())) if found.complete else None
    if not left.any():
        if not found.complete:
            return case.said("not decided", TOO_MANY)
        return case.impossible(rows, _why_not(extent), extent, pairs)
    generator = np.random.default_rng(1)
    shown: tuple[Array, ...] | None = ()
    for part in parts:
        shown = cross_products.example(rows, found, part, generator)
        if not shown and found.complete:
            shown = cross_products.every(rows, found, part)
        if shown or shown is None:
            break
    if shown == () and found.complete:
        reason = "no pairing of any data set prints it: all were tried"
        return case.impossible(rows, reason, extent, pairs)
    correlation = _correlations(found, parts) if case.test.of_two else None
    return case.said(
        "possible" if shown else "not decided",
        SHOWN if shown else UNFOUND,
        extent,
        pairs=pairs,
        correlation=correlation,
        example=shown or (),
    )


def _why_not(extent: tuple[float, float]) -> str:
    if extent[0] != extent[0]:
        return "it is not defined for any data set: nothing varies that it divides by"
    return "no sums, sums of squares and products of whole ratings print it"


def _wanted(test: PrintedTest, found: Choices) -> list[tuple[Array, Array]]:
    """Return the least and largest C that print the test, for each choice of moments."""
    n, k = found.n, found.sums.shape[1]
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
            for low, high in r_windows(test, n)
        ]
    if test.kind == "paired_t":
        low, high = (value**2 for value in t_window(test, n - 1, sqrt(n)))
        window = t_window(test, n - 1, sqrt(n))
        empty = window[0] > window[1]
    else:
        low, high = f_window(test, (k - 1, (k - 1) * (n - 1)))
        empty = low > high
    if empty:
        return []
    top = (n - 1) * found.between.astype(float)
    # Without any error the statistic is not defined, so n k times the error is 1 or more.
    with np.errstate(divide="ignore", invalid="ignore"):
        most = np.where(top > 0, top / low if low > 0 else inf, inf if low <= SLACK else -inf)
        least = top / high if high > 0 else np.where(top > 0, inf, 0.0)
    least = np.maximum(least * (1 - SLACK) ** 2 - SLACK, 1.0)
    base = found.error(np.zeros(len(top), np.int64)).astype(float)
    return [_whole((base - most * (1 + SLACK) ** 2) / (2 * n), (base - least) / (2 * n), found)]


def _whole(low: Array, high: Array, found: Choices) -> tuple[Array, Array]:
    """Return the whole numbers in an interval that no pairing's C rules out."""
    least, most = found.least.astype(float), found.most.astype(float)
    low, high = np.maximum(np.ceil(low - 1e-9), least), np.minimum(np.floor(high + 1e-9), most)
    none = low > high
    low[none], high[none] = 1, 0
    return low.astype(np.int64), high.astype(np.int64)


def _reach(found: Choices) -> Array:
    """Return n times the largest sum of products about the means, by Cauchy and Schwarz."""
    spread = np.maximum(found.n * found.squares - found.sums**2, 0).astype(float)
    found_reach: Array = np.sqrt(spread.prod(axis=1))
    return found_reach


def _extent(test: PrintedTest, found: Choices) -> tuple[float, float]:
    """Return bounds of the statistic over every choice and pairing; NaN if it is never defined."""
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
    # An error of 0 has no F; next to it comes an error of 1.
    high = top / np.maximum(smallest, 1)
    if test.kind == "rm_f":
        return float(low.min()), float(high.max())
    rises = np.sign(found.sums[:, 1] - found.sums[:, 0])[defined]
    ts = np.concatenate([rises * np.sqrt(low), rises * np.sqrt(high)])
    return float(ts.min()), float(ts.max())


def _correlations(
    found: Choices, parts: Sequence[tuple[Array, Array]]
) -> tuple[float, float] | None:
    """Return the least and largest correlation that the printed test leaves."""
    reach, middle = _reach(found), found.sums.prod(axis=1)
    ends = [
        (found.n * c - middle)[usable] / reach[usable]
        for low, high in parts
        for usable in [(low <= high) & (reach > 0)]
        for c in (low, high)
    ]
    every = np.concatenate(ends) if ends else np.zeros(0)
    return (float(every.min()), float(every.max())) if len(every) else None


def _independent(case: _Case) -> PrintedTestAnswer:
    """Answer for groups: sums first, because they need no count of data sets."""
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
        return case.impossible(rows, _why_not(extent), extent, pairs)
    if shown := _shown(rows, places[left]):
        return case.said("possible", SHOWN, extent, pairs=pairs, example=shown)
    # Some of these sums may belong to no data set: count.
    if any(solutions.not_drawn for solutions in case.columns):
        return case.said("not decided", UNFOUND, extent, pairs=pairs)
    counted = [ColumnRows(solutions) for solutions in case.columns]
    real = [{moments: at for at, moments in enumerate(row.moments)} for row in counted]
    there = [
        [real[j].get(rows[j].moments[at], -1) for j, at in enumerate(place)]
        for place in places[left].tolist()
    ]
    kept = [place for place in there if -1 not in place]
    pairs = len(places), len(kept)
    if not kept:
        return case.impossible(counted, _why_not(extent), extent, pairs)
    shown = _shown(counted, np.array(kept))
    verdict: Verdict = "possible" if shown else "not decided"
    return case.said(verdict, SHOWN if shown else UNFOUND, extent, pairs=pairs, example=shown)


def _outside(case: _Case, rows: Sequence[ColumnRows]) -> PrintedTestAnswer:
    """Answer from the extremes of each sum if there are too many choices to examine."""
    groups = [group_of(solutions) for solutions in case.columns]
    if case.test.kind == "one_way_f":
        extent = range_of_f(groups)
        window = f_window(case.test, (len(groups) - 1, sum(g.n for g in groups) - len(groups)))
    else:
        of_kind = students_t if case.test.kind == "independent_t" else welchs_t
        t, _ = of_kind(groups[0], groups[1])
        extent = float(t.min()), float(t.max())
        window = size_of(case.test.statistic, case.test.rounding)
        if case.test.kind == "independent_t":
            n = [g.n for g in groups]
            window = t_window(case.test, sum(n) - 2, 1 / sqrt(sum(1 / m for m in n)))
    least = 0.0 if extent[0] <= 0 <= extent[1] else min(map(abs, extent))
    most = max(map(abs, extent))
    if window[0] > most * (1 + SLACK) or window[1] < least * (1 - SLACK):
        return case.impossible(rows, _why_not(extent), extent)
    return case.said("not decided", TOO_MANY, extent)


def _shown(rows: Sequence[ColumnRows], places: Array) -> tuple[Array, ...]:
    """Return a data set for each group with one choice of moments, if a search finds them."""
    generator = np.random.default_rng(1)
    known: dict[tuple[int, int], Array] = {}
    for place in generator.permutation(places)[:SHOWN_FOR].tolist():
        for j, at in enumerate(place):
            if (j, at) not in known:
                known[j, at] = rows[j].some(at)
        if all(len(known[j, at]) for j, at in enumerate(place)):
            return tuple(known[j, at][0] for j, at in enumerate(place))
    return ()


def of_groups(test: PrintedTest, means: Array, variances: Array, n: Array) -> tuple[Array, Array]:
    """Return the statistic and its two-sided (for F upper) p for every choice of moments."""
    from scipy.stats import f as fisher  # noqa: PLC0415 - SciPy takes longer than the counts
    from scipy.stats import t as student  # noqa: PLC0415

    k, total = len(n), int(n.sum())
    within = ((n - 1) * variances).sum(axis=1)
    bottom = np.where(within > 0, within, nan)
    if test.kind == "one_way_f":
        centre = (n * means).sum(axis=1, keepdims=True) / total
        between = (n * (means - centre) ** 2).sum(axis=1) / (k - 1)
        values = between / (bottom / (total - k))
        return values, fisher.sf(values, k - 1, total - k)
    of_mean = variances / n
    if test.kind == "welch_t":
        squared = of_mean.sum(axis=1)
        degrees = squared**2 / np.where(within > 0, (of_mean**2 / (n - 1)).sum(axis=1), nan)
        values = (means[:, 1] - means[:, 0]) / np.sqrt(np.where(within > 0, squared, nan))
    else:
        degrees = np.full(len(means), float(total - k))
        values = (means[:, 1] - means[:, 0]) / np.sqrt(bottom / (total - k) * (1 / n).sum())
    return values, 2 * student.sf(np.abs(values), degrees)


def prints(test: PrintedTest, values: Array, p: Array, n: Array) -> Array:
    """Whether each statistic with its p is printed so."""
    low, high = p_between(test)
    left = fits(p * test.sides / 2 if test.kind != "one_way_f" else p, (low, high))
    if test.p_below is not None:
        left &= p * (test.sides / 2 if test.kind != "one_way_f" else 1) < high + SLACK
    size = np.abs(values)
    left &= fits(size, size_of(test.statistic, test.rounding))
    if test.d is not None:
        left &= fits(size * sqrt((1 / n).sum()), size_of(test.d, test.rounding))
    if test.partial_eta_squared is not None:
        degrees = len(n) - 1, int(n.sum()) - len(n)
        share = values * degrees[0] / (values * degrees[0] + degrees[1])
        left &= fits(share, size_of(test.partial_eta_squared, test.rounding))
    return left


def _counterexample(test: PrintedTest, rows: Sequence[ColumnRows]) -> tuple[Array, ...]:
    """Return ratings that print a test, by its definition alone; empty if none was found."""
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
    """Whether statistics of tables are printed so; NaN is not."""
    defined = ~np.isnan(values)
    if test.kind == "correlation":
        hit = np.zeros(len(values), dtype=bool)
        for window in r_windows(test, int(n[0])):
            hit |= fits(values, window)
        return defined & hit
    if test.kind in ("paired_t", "rm_f"):
        k = len(n)
        window = (
            t_window(test, n[0] - 1, sqrt(n[0]))
            if test.kind == "paired_t"
            else f_window(test, (k - 1, (k - 1) * (int(n[0]) - 1)))
        )
        return defined & fits(np.abs(values), window)
    means = np.stack([x.mean(axis=1) for x in columns], axis=1)
    variances = np.stack([x.var(axis=1, ddof=1) for x in columns], axis=1)
    return defined & prints(test, values, of_groups(test, means, variances, n)[1], n)
