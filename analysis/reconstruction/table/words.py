"""Describe the published numbers of a column, and the assumptions about the column."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.table.published_table import Column

# Names of the published numbers, in the order in which a description lists them.
NAMES = {
    "mean": "mean",
    "mean_percent": "mean in percent",
    "sum": "sum",
    "sd": "SD",
    "se": "SE",
    "ci_low": "interval from",
    "ci_high": "interval to",
    "maximum_deviation": "largest deviation",
    "observed_minimum": "smallest",
    "observed_maximum": "largest",
    "median": "median",
    "lower_quartile": "lower quartile",
    "upper_quartile": "upper quartile",
}


def in_words(column: Column) -> str:
    """Format all numbers published for a column as text."""
    parts = [f"n {column.n}"]
    for name, words in NAMES.items():
        printed = getattr(column, name)
        if printed is not None:
            parts.append(f"{words} {printed.text}")
    parts += [f"{value} given at least once" for value in column.present]
    parts += [f"{value} never given" for value in column.absent]
    parts += [f"{value} given {times} times" for value, times in column.frequencies]
    parts += [f"{value} given by {share.text} %" for value, share in column.percentages]
    scale = column.scale
    ends = {
        (): f"{scale.minimum} to {scale.maximum}",
        ("maximum",): f"from {scale.minimum}, maximum not printed",
        ("minimum",): f"up to {scale.maximum}, minimum not printed",
    }
    missing = tuple(name for name in ("minimum", "maximum") if name in column.assumed)
    step = "step not printed" if "step" in column.assumed else f"in steps of {scale.step}"
    return f"{', '.join(parts)}; scale {ends.get(missing, 'not printed')}, {step}"


def assumptions(column: Column) -> Iterator[str]:
    """Yield the assumptions, as text, on which the verdict on the column depends."""
    scale = column.scale
    stated = " (no step is stated)" if "step" in column.assumed else ""
    yield f"ratings change in steps of {scale.step}{stated}"
    yield f"none of the n = {column.n} ratings is missing"
    far = {"minimum": scale.minimum, "maximum": scale.maximum}
    if derived := [f"{name} {float(far[name]):g}" for name in far if name in column.assumed]:
        yield f"scale ends that are derived from the SD: {' and '.join(derived)}"
    if "sd_convention" in column.assumed:
        yield "the SD divides by n - 1 (no divisor is stated)"
    yield f"rounding: {column.rounding}"
