"""Tests that a paper prints beside its table: t, F, r and p between columns."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from slipscale.analysis.reconstruction.table.printed_fields import AsPrinted, Record

Kind = Literal["paired_t", "independent_t", "welch_t", "one_way_f", "rm_f", "correlation"]


class PrintedTest(Record):
    """A test between columns, as printed.

    Parameters
    ----------
    kind : str
        Which test; a correlation is Pearson's.
    columns : tuple of str
        Labels of the columns that it compares; all of them if empty.
    statistic : Printed, optional
        t (its sign does not count), F or r (its sign counts).
    p : Printed, optional
        Two-sided p value; for F one-sided, as it always is.
    p_below : Printed, optional
        What p is said to be below, as in "p < .001".
    rounding : {"nearest", "half_up", "half_even", "truncated"}
        How statistic and p were rounded.
    """

    kind: Kind
    columns: Annotated[tuple[str, ...], Field(max_length=50)] = ()
    statistic: AsPrinted | None = None
    p: AsPrinted | None = None
    p_below: AsPrinted | None = None
    rounding: Literal["nearest", "half_up", "half_even", "truncated"] = "nearest"

    @property
    def of_two(self) -> bool:
        """Whether it compares two columns, no more."""
        return self.kind not in ("one_way_f", "rm_f")

    @model_validator(mode="after")
    def _enough(self) -> PrintedTest:
        if not (self.statistic or self.p or self.p_below):
            raise ValueError("expected a statistic, p or p_below")
        if self.p_below and self.p_below.value <= 0:
            raise ValueError("p_below is 0 or less, which no p is below")
        if self.kind == "rm_f" and (self.p or self.p_below):
            raise ValueError(
                "leave out the p of a repeated-measures F: it depends on its correction"
            )
        if self.kind == "correlation" and not self.statistic:
            raise ValueError("expected the statistic, r")
        if self.of_two and len(self.columns) > 2:  # noqa: PLR2004 - a pair
            raise ValueError("expected two columns")
        if len(set(self.columns)) < len(self.columns) or len(self.columns) == 1:
            raise ValueError("expected two or more different columns")
        return self
