"""Represent a published column of continuous values by intervals for its mean and SD.

Infinitely many data sets of continuous values are consistent with a column, so they are not
counted. If the table states no scale, every mean and SD in these intervals is possible. On a scale
with two ends, the SD has a maximum (Bhatia and Davis, 2000). A geometric mean and the SD of
logarithms are treated as the mean and SD of natural logarithms.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, log, sqrt
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.table.published_table import OpenScale, Summary

Ends = tuple[float, float]
# Entries that are allowed for a column of continuous values.
KNOWN = {
    "label", "n", "mean", "sum", "sd", "se", "ci_low", "ci_high", "ci_percent", "ci_quantile",
    "geometric_mean", "log_sd", "log_base", "sd_convention", "rounding", "amplitude_um_pp",
}  # fmt: skip
LOG_OF_BASE = {"10": log(10), "2": log(2), "e": 1.0}


@dataclass(frozen=True, kw_only=True)
class IntervalColumn:
    """Intervals for the mean and SD (n - 1) of a column of continuous values.

    Parameters
    ----------
    label : str
        Heading of the column.
    n : int
        Number of values.
    mean, sd : tuple of (float, float)
        Intervals for the mean and the SD that follow from the published numbers. If `logarithms` is
        True, both intervals are for natural logarithms.
    scale : tuple of (float, float)
        Minimum and maximum of the scale, in the unit of the mean. If the minimum or maximum is not
        stated, its value is infinite.
    logarithms : bool
        Whether the mean and SD describe logarithms.
    printed : str
        All numbers published for the column, as text.
    reason : str
        Reason why the mean and SD are impossible. Empty if the mean and SD are possible.
    """

    label: str
    n: int
    mean: Ends
    sd: Ends
    scale: Ends
    logarithms: bool
    printed: str
    reason: str = ""

    def assumptions(self) -> Iterator[str]:
        """Yield the assumptions about the column's values, as text."""
        kind = "logarithms of positive values" if self.logarithms else "continuous values"
        yield f"{kind}, with any number of decimals"
        yield f"n = {self.n} values, none of which is missing"


def interval_column(summary: Summary, scale: OpenScale) -> IntervalColumn:
    """Return the intervals for the mean and SD of continuous values.

    Raises
    ------
    ValueError
        If the column has entries that cannot be used for continuous values, such as a median, or
        has no SD, SE or confidence interval.
    """
    if more := sorted(summary.model_fields_set - KNOWN):
        raise ValueError(f"omit {', '.join(more)}: only mean and SD are used for continuous values")
    if summary.geometric_mean is not None and summary.log_sd is not None:
        return _of_logarithms(summary, scale)
    mean = inf, -inf
    for printed, factor in summary.means():
        values = printed.values(summary.rounding).scaled(1 / factor)
        mean = float(values.low), float(values.high)
    sd = _sd(summary)
    ends = (
        -inf if scale.minimum is None else float(scale.minimum),
        inf if scale.maximum is None else float(scale.maximum),
    )
    return _column(summary, mean, sd, ends, logarithms=False)


def _of_logarithms(summary: Summary, scale: OpenScale) -> IntervalColumn:
    if summary.geometric_mean is None or summary.log_sd is None:
        raise ValueError("geometric_mean and log_sd must be given together")
    values = summary.geometric_mean.values(summary.rounding)
    if values.high <= 0:
        raise ValueError("geometric_mean must be above 0")
    spread = summary.log_sd.values(summary.rounding)
    unit = LOG_OF_BASE[summary.log_base] * _to_sample(summary)
    sd = max(float(spread.low), 0.0) * unit, float(spread.high) * unit
    low = log(values.low) if values.low > 0 else -inf
    ends = (
        log(scale.minimum) if scale.minimum else -inf,
        log(scale.maximum) if scale.maximum else inf,
    )
    return _column(summary, (low, log(values.high)), sd, ends, logarithms=True)


def _to_sample(summary: Summary) -> float:
    """Return the factor that converts the published SD to a sample SD, which divides by n - 1."""
    return sqrt(summary.n / (summary.n - 1)) if summary.sd_convention == "population" else 1.0


def _sd(summary: Summary) -> Ends:
    """Return the SDs (n - 1) that match the published SD, SE and confidence interval."""
    found = []
    for printed, factor in ((summary.sd, 1.0), (summary.se, sqrt(summary.n))):
        if printed is not None:
            values = printed.values(summary.rounding)
            unit = factor * _to_sample(summary)
            found.append((max(float(values.low), 0.0) * unit, float(values.high) * unit))
    if summary.ci_low is not None and summary.ci_high is not None:
        low, high = (end.values(summary.rounding) for end in (summary.ci_low, summary.ci_high))
        unit = sqrt(summary.n) / (2 * summary.quantile)
        found.append(
            (max(float(high.low - low.high), 0.0) * unit, float(high.high - low.low) * unit)
        )
    if not found:
        raise ValueError("expected an sd, an se or a confidence interval")
    return max(low for low, _ in found), min(high for _, high in found)


def _column(
    summary: Summary, mean: Ends, sd: Ends, scale: Ends, *, logarithms: bool
) -> IntervalColumn:
    names = ("mean", "sum", "sd", "se", "ci_low", "ci_high", "geometric_mean", "log_sd")
    printed_values = [
        f"{name.replace('_', ' ')} {printed.text}"
        for name in names
        if (printed := getattr(summary, name)) is not None
    ]
    if logarithms:
        printed_values.append(f"logarithms to base {summary.log_base}")
    inside = max(mean[0], scale[0]), min(mean[1], scale[1])
    reason = ""
    if sd[0] > sd[1]:
        reason = "the published SD, SE and confidence interval contradict each other"
    elif inside[0] > inside[1]:
        reason = "the mean lies outside the scale"
    elif sd[0] > (most := _largest_sd(inside, scale, summary.n)) * (1 + 1e-9):
        reason = f"on this scale, the SD for this mean is at most {most:.4g}"
    return IntervalColumn(
        label=summary.label,
        n=summary.n,
        mean=inside if not reason else mean,
        sd=sd,
        scale=scale,
        logarithms=logarithms,
        printed=f"n {summary.n}, {', '.join(printed_values)}",
        reason=reason,
    )


def _largest_sd(mean: Ends, scale: Ends, n: int) -> float:
    """Return the largest possible SD (n - 1) of values on a scale (Bhatia and Davis, 2000)."""
    if inf in scale or -inf in scale:
        return inf
    centre = min(max(sum(scale) / 2, mean[0]), mean[1])
    return sqrt((centre - scale[0]) * (scale[1] - centre) * n / (n - 1))
