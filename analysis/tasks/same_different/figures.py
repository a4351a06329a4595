"""Plot the sensitivity of pairs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from slipscale.analysis.statistics.not_computed import computed
from slipscale.analysis.writing.points import SIZE, draw_means
from slipscale.figure_style import ORANGE, styled

if TYPE_CHECKING:
    from slipscale.analysis.tasks.same_different.statistics import TaskPairs


@styled
def sensitivities(task: TaskPairs) -> Figure:
    """Draw d' for each pair: means across participants with intervals, and d' from all answers."""
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.add_subplot()
    for place, each in enumerate(task.pairs):
        if found := computed(each.mean_d_prime):
            draw_means(axes, np.array([float(place)]), [found.mean], [found.interval])
        axes.plot([place], [each.d_prime], "x", color=ORANGE, markersize=6, zorder=5)
    names = [f"{each.first}\n{each.second}" for each in task.pairs]
    axes.set_xticks(range(len(names)), names)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("Pair")
    axes.set_ylabel("d' (differencing model)")
    return figure
