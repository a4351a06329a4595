"""Plot ratio judgements."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from slipscale.analysis.statistics.regression import fit_lines
from slipscale.analysis.tasks.ratios.statistics import log_cells
from slipscale.analysis.writing.points import SIZE, draw_means, draw_people, make_logarithmic
from slipscale.figure_style import BLUE, GREY, INK, styled

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from slipscale.analysis.tasks.ratios.statistics import TaskRatios
    from slipscale.stimuli.quantity import Quantity

    Array = NDArray[np.float64]


@styled
def ratios(found: TaskRatios, trials: pd.DataFrame, quantity: Quantity) -> Figure:
    """Plot ratios to the standard on logarithmic axes: participants, and geometric means."""
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.add_subplot()
    main = trials[~trials["catch"] & (trials["standard_um_pp"] == found.standard_um_pp)]
    table = log_cells(main, "comparison_um_pp", "ratio")
    table = table.loc[:, table.columns.to_numpy(float) > 0]  # no 0 on a logarithmic axis
    shown = [each for each in found.surfaces if each.comparison_um_pp > 0]
    amplitudes = table.columns.to_numpy(float)
    draw_people(axes, amplitudes, np.exp(table.to_numpy(float)))
    means = [each.ratio for each in shown]
    draw_means(axes, amplitudes, means, [each.interval for each in shown])
    if found.power_law:
        line = fit_lines(np.log(amplitudes), np.log(means))
        axes.plot(
            amplitudes,
            np.exp(line.intercept + line.slope * np.log(amplitudes)),
            color=BLUE,
            zorder=2,
        )
    axes.plot(
        [found.standard_um_pp], [1.0], "D", color=INK, markersize=5, zorder=4, label="standard"
    )
    axes.axhline(1, color=GREY, linewidth=0.8, linestyle=":", zorder=0)
    make_logarithmic(axes, np.append(amplitudes, found.standard_um_pp))
    axes.set_xlabel(quantity.headed(quantity.title))
    axes.set_ylabel(f"Times as {quantity.adjective} as the standard")
    axes.legend(loc="lower right")
    return figure
