"""Represent the statistical tests that were published with a table."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from slipscale.analysis.reconstruction.table.printed_fields import AsPrinted
from slipscale.faults.frozen_table import FrozenTable

Kind = Literal["paired_t", "independent_t", "welch_t", "one_way_f", "rm_f", "correlation"]
OF_F = ("one_way_f", "rm_f")


class PrintedTest(FrozenTable):
    """A published statistical test that compares columns of the table.

    Parameters
    ----------
    kind : str
        The kind "correlation" is Pearson's r.
    columns : tuple of str
        Labels of the columns that the test compares. If empty, all columns are compared.
    statistic : Printed, optional
        Published value of t, F or r. The sign of t is ignored, but the sign of r is used.
    p : Printed, optional
        Published p-value. For F, the p-value is always the upper-tail probability.
    p_below : Printed, optional
        Upper limit of the p-value, as in "p < .001".
    sides : {2, 1}
        Whether the p-value of t or r is two-sided, or one-sided in the direction of the difference.
    d : Printed, optional
        Cohen's d of a t test: the mean difference divided by the SD of the differences (paired) or
        by the pooled SD (independent). The sign is ignored.
    partial_eta_squared : Printed, optional
        Partial η² of an F test.
    rounding : {"nearest", "half_up", "half_even", "truncated"}
        Rounding rule of the published numbers.
    """

    kind: Kind
    columns: Annotated[tuple[str, ...], Field(max_length=50)] = ()
    statistic: AsPrinted | None = None
    p: AsPrinted | None = None
    p_below: AsPrinted | None = None
    sides: Literal[1, 2] = 2
    d: AsPrinted | None = None
    partial_eta_squared: AsPrinted | None = None
    rounding: Literal["nearest", "half_up", "half_even", "truncated"] = "nearest"

    @property
    def of_two(self) -> bool:
        """Whether a test of this kind compares exactly two columns."""
        return self.kind not in OF_F

    @model_validator(mode="after")
    def _enough(self) -> PrintedTest:
        for wrong, message in (
            (
                not any((self.statistic, self.p, self.p_below, self.d, self.partial_eta_squared)),
                "expected a statistic, p, p_below, d or partial_eta_squared",
            ),
            (
                self.p_below is not None and self.p_below.value <= 0,
                "p_below must be above 0",
            ),
            (
                self.kind == "rm_f" and bool(self.p or self.p_below),
                "omit the p-value of a repeated-measures F, because it depends on the correction",
            ),
            (
                self.kind in OF_F and self.sides == 1,
                "omit sides, because the p-value of an F test is always one-sided",
            ),
            (
                self.d is not None and self.kind not in ("paired_t", "independent_t"),
                f"d is an effect size for paired_t or independent_t, not for {self.kind}",
            ),
            (
                self.partial_eta_squared is not None and self.kind not in OF_F,
                f"partial_eta_squared is an effect size for one_way_f or rm_f, not for {self.kind}",
            ),
            (self.of_two and len(self.columns) > 2, "expected two columns"),  # noqa: PLR2004 - a pair
            (
                len(set(self.columns)) < len(self.columns) or len(self.columns) == 1,
                "expected two or more different columns",
            ),
        ):
            if wrong:
                raise ValueError(message)
        return self
