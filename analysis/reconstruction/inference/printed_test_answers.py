"""Whether tests printed beside a table can come from the data sets that the table allows.

Of independent groups n, sums and sums of squares decide. Of the same participants the sum of
products decides, too, which the pairing leaves open: a printed t or r settles it, so that the
correlation between the columns is known although no table prints it. What is possible by these
numbers is shown by a table of ratings, found by exchanging ratings, wherever one is found.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from math import ceil, floor, inf, sqrt
from typing import TYPE_CHECKING, Literal

import numpy as np

from slipscale.analysis.reconstruction.inference.comparable_columns import require_comparable
from slipscale.analysis.reconstruction.inference.extreme_t import t_of_moments
from slipscale.analysis.reconstruction.inference.independent import (
    every_f,
    group_of,
    range_of_f,
    students_t,
    welchs_t,
)
from slipscale.analysis.reconstruction.inference.least_f import least_f
from slipscale.analysis.reconstruction.inference.sums_of_products import Pair, example
from slipscale.faults import UserError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
    from slipscale.analysis.reconstruction.inference.conclusions import Ratings
    from slipscale.analysis.reconstruction.table.printed_tests import PrintedTest
    from slipscale.analysis.reconstruction.table.rounding import Printed

Verdict = Literal["possible", "impossible", "not decided"]
# Floating point's share in what is compared with a printed number.
SLACK = 1e-9
# Pairs of sums and sums of squares that are taken in turn.
COMBINATIONS = 1_000_000
WORDS = {
    "paired_t": "paired t",
    "independent_t": "independent t",
    "welch_t": "Welch's t",
    "one_way_f": "one-way F",
    "rm_f": "repeated-measures F",
    "correlation": "correlation",
}


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
    low, high : float
        The statistic over all data sets and pairings; `high` is infinite where nothing bounds it.
    pairs, pairs_left : int or None
        How many choices of a sum and a sum of squares for each column there are, and with how many
        the test can be printed; None where they are not taken in turn.
    correlation_low, correlation_high : float or None
        The correlation that the printed test leaves; None for independent groups.
    example : tuple of tuple of float
        Ratings that print the test, a row a column; empty if none are known.
    """

    kind: str
    labels: tuple[str, ...]
    printed: str
    verdict: Verdict
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
    if any(solutions.targets.refused for solutions in chosen):
        return _said(test, chosen, "not decided", (-inf, inf))
    if any(not solutions.attained[0] for solutions in chosen):
        return _said(test, chosen, "impossible", (-inf, inf))
    if test.kind in ("independent_t", "welch_t"):
        return _of_groups(test, chosen)
    if test.kind == "one_way_f":
        return _one_way_f(test, chosen)
    require_comparable(chosen)
    return _rm_f(test, chosen) if test.kind == "rm_f" else _of_products(test, chosen)


def _said(
    test: PrintedTest,
    columns: Sequence[Solutions],
    verdict: Verdict,
    extent: tuple[float, float],
    pairs: tuple[int, int] | None = None,
) -> PrintedTestAnswer:
    return PrintedTestAnswer(
        kind=test.kind,
        labels=tuple(s.column.label for s in columns),
        printed=in_words(test),
        verdict=verdict,
        low=extent[0],
        high=extent[1],
        pairs=pairs[0] if pairs else None,
        pairs_left=pairs[1] if pairs else None,
    )


def in_words(test: PrintedTest) -> str:
    """Return what is printed of a test."""
    sign = {"correlation": "r", "one_way_f": "F", "rm_f": "F"}.get(test.kind, "t")
    parts = ((sign, " = ", test.statistic), ("p", " = ", test.p), ("p", " < ", test.p_below))
    return ", ".join(f"{name}{how}{text.text}" for name, how, text in parts if text is not None)


def _between(printed: Printed | None, rule: str) -> tuple[float, float]:
    """Return what a printed number is between; everything if it is not printed."""
    if printed is None:
        return -inf, inf
    values = printed.values(rule)
    return float(values.low), float(values.high)


def _fits(values: Array, printed: Printed | None, rule: str) -> Array:
    low, high = _between(printed, rule)
    slack = SLACK * (1 + np.abs(values))
    found: Array = (values >= low - slack) & (values <= high + slack)
    return found


def _p_fits(test: PrintedTest, p: Array) -> Array:
    fits = _fits(p, test.p, test.rounding)
    return fits if test.p_below is None else fits & (p < float(test.p_below.value) + SLACK)


def _of_groups(test: PrintedTest, columns: list[Solutions]) -> PrintedTestAnswer:
    """Answer for t of independent groups: every pair of pairs."""
    from scipy.stats import t as student  # noqa: PLC0415 - SciPy takes longer than the counts

    a, b = (group_of(solutions) for solutions in columns)
    t, degrees = (students_t if test.kind == "independent_t" else welchs_t)(a, b)
    p = 2 * student.sf(np.abs(t), degrees)
    fits = _fits(np.abs(t), test.statistic and _unsigned(test.statistic), test.rounding)
    fits &= _p_fits(test, p)
    known = all(group.sharp and group.complete for group in (a, b))
    return _of_choices(test, columns, fits, (float(t.min()), float(t.max())), known=known)


def _unsigned(printed: Printed) -> Printed:
    return type(printed)(printed.text.lstrip("+-"))


def _of_choices(
    test: PrintedTest,
    columns: list[Solutions],
    fits: Array,
    extent: tuple[float, float],
    *,
    known: bool,
) -> PrintedTestAnswer:
    """Answer from whether each choice of sums and sums of squares prints the test."""
    verdict: Verdict = "possible" if fits.any() and known else "not decided"
    complete = all(group_of(solutions).complete for solutions in columns)
    if not fits.any() and complete:
        verdict = "impossible"
    return _said(test, columns, verdict, extent, (fits.size, int(fits.sum())))


def _one_way_f(test: PrintedTest, columns: list[Solutions]) -> PrintedTestAnswer:
    from scipy.stats import f as fisher  # noqa: PLC0415

    groups = [group_of(solutions) for solutions in columns]
    degrees = len(groups) - 1, sum(group.n for group in groups) - len(groups)
    low, high = range_of_f(groups)
    every = every_f(groups) if all(group.complete for group in groups) else None
    if every is not None:
        fits = _fits(every, test.statistic, test.rounding)
        fits &= _p_fits(test, fisher.sf(every, *degrees))
        known = all(group.sharp for group in groups)
        return _of_choices(test, columns, fits, (low, high), known=known)
    asked = _f_between(test, degrees)
    apart = asked[0] > high * (1 + SLACK) or asked[1] < low * (1 - SLACK)
    return _said(test, columns, "impossible" if apart else "not decided", (low, high))


def _f_between(test: PrintedTest, degrees: tuple[int, int]) -> tuple[float, float]:
    """Return what F lies between by the printed F and p."""
    from scipy.stats import f as fisher  # noqa: PLC0415

    low, high = _between(test.statistic, test.rounding)
    least_p, most_p = _p_between(test)
    return max(low, float(fisher.isf(most_p, *degrees))), min(
        high, float(fisher.isf(least_p, *degrees))
    )


def _p_between(test: PrintedTest) -> tuple[float, float]:
    low, high = _between(test.p, test.rounding)
    if test.p_below is not None:
        high = min(high, float(test.p_below.value))
    return max(low, 0.0), min(high, 1.0)


def _rm_f(test: PrintedTest, columns: list[Solutions]) -> PrintedTestAnswer:
    """Answer for the repeated-measures F: only its least value is known."""
    least = least_f([solutions.attained[0] for solutions in columns], columns[0].column.n)
    low = 0.0 if least is None else least
    _, most = _between(test.statistic, test.rounding)
    verdict: Verdict = "impossible" if most < low * (1 - SLACK) else "not decided"
    return _said(test, columns, verdict, (low, inf))


def _of_products(test: PrintedTest, columns: list[Solutions]) -> PrintedTestAnswer:
    """Answer for the paired t and the correlation: the sum of products is settled by them."""
    n = columns[0].column.n
    (first, sharp), (second, also) = (solutions.attained for solutions in columns)
    outer = (-1.0, 1.0)
    if test.kind == "paired_t":
        bounds = t_of_moments(first, second, n)
        outer = bounds.low, bounds.high
    number = len(first) * len(second)
    if number > COMBINATIONS:
        return _said(test, columns, "not decided", outer)
    pairs = [pair for a, b in product(first, second) if (pair := _pair(test, a, b, n))]
    found = _said(test, columns, "not decided", outer, (number, len(pairs)))
    if not pairs:
        # Every sum and sum of squares that some data set has is among them.
        return replace(found, verdict="impossible")
    ends = [pair.correlations(n) for pair in pairs]
    shown = example(columns, pairs) if sharp and also else ()
    return replace(
        found,
        verdict="possible" if shown else "not decided",
        correlation_low=min(low for low, _ in ends),
        correlation_high=max(high for _, high in ends),
        example=shown,
    )


def _pair(test: PrintedTest, a: tuple[int, int], b: tuple[int, int], n: int) -> Pair | None:
    """Return the sums of products that print the test beside these sums; None if there is none."""
    roots = sqrt(max(n * a[1] - a[0] ** 2, 0)), sqrt(max(n * b[1] - b[0] ** 2, 0))
    if not all(roots):
        return None
    reach = roots[0] * roots[1]
    # n times the sum of products, less the product of the sums: by Cauchy and Schwarz.
    low, high = -reach, reach
    if test.kind == "correlation":
        least, most = _between(test.statistic, test.rounding)
        low, high = max(low, least * reach), min(high, most * reach)
    else:
        scatter = _scatter_of_t(test, b[0] - a[0], n)
        if scatter is None:
            return None
        # n times the squared deviations of the differences.
        own = roots[0] ** 2 + roots[1] ** 2
        low, high = max(low, (own - scatter[1]) / 2), min(high, (own - scatter[0]) / 2)
    slack = SLACK * reach
    products = range(
        ceil((low + a[0] * b[0] - slack) / n), floor((high + a[0] * b[0] + slack) / n) + 1
    )
    return Pair((a[0], b[0]), (a[1], b[1]), roots, products) if products else None


def _scatter_of_t(test: PrintedTest, difference: int, n: int) -> tuple[float, float] | None:
    """Return n times the squared deviations of n differences, by what is printed of t."""
    from scipy.stats import t as student  # noqa: PLC0415

    low, high = _between(test.statistic and _unsigned(test.statistic), test.rounding)
    least_p, most_p = _p_between(test)
    low = max(low, float(student.isf(most_p / 2, n - 1)), 0.0)
    high = min(high, float(student.isf(least_p / 2, n - 1)) if least_p > 0 else inf)
    if low > high:
        return None
    top = difference**2 * (n - 1)
    if not top:
        return (0.0, inf) if low <= SLACK else None
    return top / high**2 if high < inf else 0.0, top / low**2 if low > 0 else inf
