"""Draw individual lines, means and standards in figures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.writing.axes import LINES_AT_MOST, apart, tip
from slipscale.figure_style import BLUE, INK, PALE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval

    Array = NDArray[np.float64]


SIZE = (5.6, 3.9)  # inches


def draw_people(axes: Axes, places: Array, values: Array) -> None:
    """Draw one pale line per participant, for at most `LINES_AT_MOST` participants."""
    for row in values[:LINES_AT_MOST]:
        axes.plot(places, row, "o-", color=PALE, linewidth=0.8, markersize=2.5, alpha=0.6, zorder=1)


def draw_means(
    axes: Axes,
    places: Array,
    means: Sequence[float],
    intervals: Sequence[ConfidenceInterval | None],
) -> None:
    """Draw means with their confidence intervals."""
    for place, mean, interval in zip(places, means, intervals, strict=True):
        if interval is not None:
            axes.plot([place, place], list(interval), color=BLUE, linewidth=2.2, zorder=3)
        axes.plot([place], [mean], "o", color=BLUE, zorder=4, gid=tip(f"{place:g}: {mean:.3g}"))


def draw_standard(axes: Axes, x: float, y: float) -> None:
    """Draw a marker for the standard."""
    axes.plot([x], [y], "D", color=INK, markersize=5, zorder=5, linewidth=0, label="standard")


def make_logarithmic(axes: Axes, places: Array) -> None:
    """Make both axes logarithmic, with plain numbers as tick labels."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    ticks = apart(axes, np.unique(places))
    axes.set_xticks(ticks, [f"{value:g}" for value in ticks])
    axes.minorticks_off()
    axes.yaxis.set_major_formatter("{x:g}")
    low, high = axes.get_ylim()
    first, last = np.floor(np.log10([low, high])).astype(int)
    steps = [m * 10.0**p for p in range(first, last + 1) for m in (1, 2, 5)]
    axes.set_yticks([step for step in steps if low <= step <= high])
