"""Plot magnitude production."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from slipscale.analysis.statistics.regression import fit_lines
from slipscale.analysis.tasks.ratios.statistics import log_cells
from slipscale.analysis.writing.points import (
    SIZE,
    draw_means,
    draw_people,
    draw_standard,
    make_logarithmic,
)
from slipscale.figure_style import BLUE, styled

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from slipscale.analysis.tasks.productions.statistics import TaskProductions
    from slipscale.stimuli.quantity import Quantity

    Array = NDArray[np.float64]


@styled
def productions(found: TaskProductions, trials: pd.DataFrame, quantity: Quantity) -> Figure:
    """Plot produced levels against numbers on logarithmic axes: participants, and means."""
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.add_subplot()
    table = log_cells(trials[~trials["catch"]], "number", "produced_um_pp")
    numbers = table.columns.to_numpy(float)
    draw_people(axes, numbers, np.exp(table.to_numpy(float)))
    means = [each.amplitude_um_pp for each in found.numbers]
    draw_means(axes, numbers, means, [each.interval for each in found.numbers])
    if found.slope:
        line = fit_lines(np.log(numbers), np.log(means))
        axes.plot(
            numbers, np.exp(line.intercept + line.slope * np.log(numbers)), color=BLUE, zorder=2
        )
    draw_standard(axes, found.modulus, found.standard_um_pp)
    make_logarithmic(axes, np.append(numbers, found.modulus))
    axes.set_xlabel("Number shown")
    axes.set_ylabel(quantity.headed(f"{quantity.title} produced"))
    axes.legend(loc="lower right")
    return figure
