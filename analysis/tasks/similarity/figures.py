"""Plot the dissimilarity map and its stress."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from slipscale.figure_style import BLUE, GREY, styled

if TYPE_CHECKING:
    from slipscale.analysis.tasks.similarity.statistics import TaskMap


@styled
def similarity(found: TaskMap) -> Figure:
    """Draw items on the first two principal axes with equal scales, and stress by dimensions."""
    figure = Figure(figsize=(6.8, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=[1.7, 1])
    for item, place in found.coordinates.items():
        x, y = (*place, 0.0)[:2]
        left.plot(x, y, "o", color=BLUE, markersize=6)
        left.annotate(item, (x, y), xytext=(5, 4), textcoords="offset points", fontsize=8.5)
    left.axhline(0, color=GREY, linewidth=0.6, zorder=0)
    left.axvline(0, color=GREY, linewidth=0.6, zorder=0)
    left.set_aspect("equal", adjustable="datalim")
    left.margins(0.15)
    left.set_xlabel("Axis 1")
    left.set_ylabel("Axis 2")
    dimensions = np.array(list(found.stress))
    right.plot(dimensions, list(found.stress.values()), "o-", color=BLUE)
    right.set_xticks(dimensions)
    right.set_ylim(bottom=0)
    right.set_xlabel("Dimensions")
    right.set_ylabel("Stress-1")
    return figure
