"""Represent published tests and the verdicts on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Literal, TypeVar

from slipscale.analysis.reconstruction.inference.comparable_columns import values_of
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
    from slipscale.analysis.reconstruction.inference.conclusions import Ratings
    from slipscale.analysis.reconstruction.table.printed_tests import PrintedTest

T = TypeVar("T")
Verdict = Literal["possible", "impossible", "not decided"]
WORDS = {
    "paired_t": "paired t",
    "independent_t": "independent-samples t",
    "welch_t": "Welch's t",
    "one_way_f": "one-way F",
    "rm_f": "repeated-measures F",
    "correlation": "correlation",
}
PAIRED = ("paired_t", "correlation", "rm_f")


@dataclass(frozen=True, kw_only=True)
class PrintedTestAnswer:
    """The verdict on a published test, with its evidence.

    Parameters
    ----------
    kind : str
    labels : tuple of str
        Labels of the columns that the test compares.
    printed : str
        All numbers published for the test, as text.
    verdict : {"possible", "impossible", "not decided"}
        Whether any data set and pairing reproduce the published test.
    reason : str
        Reason for the verdict, as a clause.
    low, high : float
        Bounds on the statistic over all data sets and pairings. Not every value between the bounds
        is necessarily possible. `high` may be infinite. Both bounds are NaN if the statistic is
        always undefined.
    pairs, pairs_left : int or None
        Number of combinations of one sum and one sum of squares per column, and number of these
        combinations that can give the published test. Both are None if combinations were not
        examined one by one.
    correlation_low, correlation_high : float or None
        Range of correlations that are compatible with the published test. None if this range is not
        computed, for example for independent groups.
    example : tuple of tuple of float
        Ratings that reproduce the published test, one row per column. Empty if no such ratings are
        known.
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
        """The test as text."""
        return f"{WORDS[self.kind]} of {', '.join(self.labels)}"


@dataclass(frozen=True)
class Case:
    """A published test with the columns that it compares."""

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
        """Return an answer with the given verdict.

        `example` contains one row of ratings per column, in steps above the scale minimum.
        """
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


SHOWN = "the ratings below give the published value"
TOO_MANY = "there are too many possible sums and sums of squares to examine all of them"
UNFOUND = "the value is within the bounds, but the search found no ratings that give it"


def chosen_columns(test: PrintedTest, columns: Sequence[tuple[str, T]]) -> list[T]:
    """Return the columns that a test compares, in the order given by the test.

    Raises
    ------
    UserError
        If a test of two columns does not name them and the table does not have exactly two columns.
    """
    chosen = [column for _, column in columns]
    if test.columns:
        chosen = [column for wanted in test.columns for label, column in columns if label == wanted]
    if test.of_two and len(chosen) != 2:  # noqa: PLR2004 - a pair
        raise UserError(
            "test '{kind}': expected the labels of the two columns to compare", kind=test.kind
        )
    return chosen


def in_words(test: PrintedTest) -> str:
    """Format all numbers published for a test as text.

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
