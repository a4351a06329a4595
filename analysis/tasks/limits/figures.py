"""Plot transitions for the method of limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from slipscale.analysis.statistics.not_computed import computed
from slipscale.analysis.writing.points import SIZE, draw_means, draw_people
from slipscale.figure_style import styled

if TYPE_CHECKING:
    from slipscale.analysis.tasks.limits.statistics import TaskLimits
    from slipscale.stimuli.quantity import Quantity

NAMES = ("Ascending", "Descending", "Both")


@styled
def transitions(task: TaskLimits, quantity: Quantity) -> Figure:
    """Draw participants' mean transitions by direction, and the means with intervals."""
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.add_subplot()
    rows = [(p.ascending_um_pp, p.descending_um_pp, p.threshold_um_pp) for p in task.people]
    draw_people(axes, np.arange(3.0), np.array(rows, np.float64))
    for place, each in enumerate(
        (task.ascending_um_pp, task.descending_um_pp, task.threshold_um_pp)
    ):
        if found := computed(each):
            draw_means(axes, np.array([float(place)]), [found.mean], [found.interval])
    axes.set_xticks(range(3), NAMES)
    axes.set_ylabel(quantity.headed("Transition"))
    axes.set_xlabel("Series")
    return figure
