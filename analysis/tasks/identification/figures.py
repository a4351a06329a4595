"""Plot the table of presented and named surfaces (confusion matrix)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from slipscale.figure_style import styled

if TYPE_CHECKING:
    from slipscale.analysis.tasks.identification.statistics import TaskIdentification

#: Proportions above this are written in white.
DARK = 0.5


@styled
def named(task: TaskIdentification) -> Figure:
    """Draw the proportion of each name among the answers to each presented surface."""
    figure = Figure(figsize=(4.6, 4.2), layout="constrained")
    axes = figure.add_subplot()
    counts = np.array(task.table, np.float64)
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    axes.imshow(shares, cmap="Blues", vmin=0, vmax=1)
    for (row, column), share in np.ndenumerate(shares):
        axes.text(
            column,
            row,
            f"{100 * share:.0f}",
            ha="center",
            va="center",
            fontsize=8.5,
            color="white" if share > DARK else "black",
        )
    places = range(len(task.items))
    axes.set_xticks(places, task.items)
    axes.set_yticks(places, task.items)
    axes.grid(visible=False)
    axes.set_xlabel("Named")
    axes.set_ylabel("Presented (answers in %)")
    return figure
