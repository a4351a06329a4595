"""Plot movement time against the index of difficulty."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from slipscale.analysis.statistics.not_computed import computed
from slipscale.analysis.writing.axes import LINES_AT_MOST
from slipscale.analysis.writing.points import SIZE
from slipscale.figure_style import BLUE, ORANGE, PALE, styled

if TYPE_CHECKING:
    from slipscale.analysis.tasks.pointing.statistics import TaskPointing


@styled
def movement_times(task: TaskPointing) -> Figure:
    """Draw participants' mean movement times, their means, and the mean line per condition."""
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.add_subplot()
    for condition, colour in zip(task.conditions, (BLUE, ORANGE), strict=False):
        cells = [cell for each in condition.people for cell in each.cells]
        if not cells:
            continue
        for each in condition.people[:LINES_AT_MOST]:
            bits, times = [c.bits for c in each.cells], [c.movement_time_s for c in each.cells]
            axes.plot(bits, times, "o", color=PALE, markersize=2.5, zorder=1)
        ends = np.unique([cell.bits for cell in cells])
        means = [np.mean([c.movement_time_s for c in cells if c.bits == bits]) for bits in ends]
        axes.plot(ends, means, "o", color=colour, zorder=4, label=f"feedback: {condition.feedback}")
        intercept, slope = computed(condition.intercept_s), computed(condition.slope_s_per_bit)
        if intercept and slope:
            axes.plot(ends, intercept.mean + slope.mean * ends, color=colour, zorder=3)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("Index of difficulty (bit)")
    axes.set_ylabel("Movement time (s)")
    if len(task.conditions) > 1:
        axes.legend()
    return figure
