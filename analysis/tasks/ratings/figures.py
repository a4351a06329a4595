"""Plot ratings on a visual analogue scale."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from slipscale.analysis.tasks.ratings.statistics import cells
from slipscale.analysis.writing.axes import apart
from slipscale.analysis.writing.points import SIZE, draw_means, draw_people
from slipscale.figure_style import GREY, styled

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from slipscale.analysis.tasks.ratings.statistics import TaskRatings
    from slipscale.stimuli.quantity import Quantity

    Array = NDArray[np.float64]


@styled
def ratings(found: TaskRatings, trials: pd.DataFrame, quantity: Quantity) -> Figure:
    """Draw the scale from 0 to 100: participants' mean ratings, and the means with intervals.

    Parameters
    ----------
    found : TaskRatings
    trials : DataFrame
        The trials of `slipscale.analysis.tasks.ratings.reading.TRIALS` of the task.
    quantity : Quantity
    """
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.add_subplot()
    main = trials[~trials["catch"]]
    table = cells(main)
    plain = main.loc[main["amplitude_um_pp"].notna(), "surface"].astype(str).unique()
    whole = set(table.columns) == set(plain)
    # Textures have no position on an amplitude axis, so all surfaces are then drawn side by side.
    places = np.array(
        [float(name) for name in table.columns] if whole else range(len(table.columns)), float
    )
    draw_people(axes, places, table.to_numpy(float))
    draw_means(
        axes,
        places,
        [each.mean for each in found.surfaces],
        [each.interval for each in found.surfaces],
    )
    low, high = (0, 100) if found.categories is None else (1, found.categories)
    room = 0.03 * (high - low)
    axes.set_ylim(low - room, high + room)
    for end in (low, high):
        axes.axhline(end, color=GREY, linewidth=0.8, linestyle=":", zorder=0)
    axes.set_xticks(places, list(table.columns))
    if whole:
        shown = apart(axes, places)
        axes.set_xticks(shown, [f"{value:g}" for value in shown])
    axes.set_xlabel(quantity.headed(quantity.title) if whole else "Surface")
    axes.set_ylabel("Position on the line (0 to 100)" if low == 0 else f"Category (1 to {high})")
    return figure
