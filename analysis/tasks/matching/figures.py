"""Plot matches to references."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.figure_style import BLUE, GREY, INK, VERMILION, styled

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd

    from slipscale.analysis.tasks.matching.statistics import MatchedReference
    from slipscale.stimuli.quantity import Quantity


@styled
def matches(found: Sequence[MatchedReference], trials: pd.DataFrame, quantity: Quantity) -> Figure:
    """Draw matches against references: participants, and means from below and from above.

    Parameters
    ----------
    found : sequence of MatchedReference
        References of one task.
    trials : DataFrame
        The trials of `slipscale.analysis.tasks.matching.reading.TRIALS` of the task.
    quantity : Quantity
    """
    figure = Figure(figsize=(5.6, 4.2), layout="constrained")
    axes = figure.add_subplot()
    means = trials.groupby([PARTICIPANT, "reference_um_pp", "direction"], observed=True)[
        "matched_um_pp"
    ].mean()
    table = means.reset_index()
    ends = [
        min(each.reference_um_pp for each in found),
        max(each.reference_um_pp for each in found),
    ]
    margin = 0.08 * (ends[1] - ends[0] or ends[1])
    line = np.array([ends[0] - margin, ends[1] + margin])
    axes.plot(line, line, color=GREY, linewidth=0.9, linestyle=":", label="equal", zorder=0)
    for direction, colour, marker, shift in (
        ("ascending", BLUE, "^", -1),
        ("descending", VERMILION, "v", 1),
    ):
        own = table[table["direction"] == direction]
        axes.plot(
            own["reference_um_pp"] + shift * 0.15 * margin,
            own["matched_um_pp"],
            marker,
            color=colour,
            markersize=4,
            alpha=0.45,
            zorder=1,
        )
        points = [
            (each.reference_um_pp, each.ascending_um_pp if shift < 0 else each.descending_um_pp)
            for each in found
        ]
        known = [(x, y) for x, y in points if y is not None]
        if known:
            axes.plot(
                *zip(*known, strict=True),
                marker=marker,
                color=colour,
                markersize=8,
                linewidth=0,
                markeredgecolor=INK,
                label=f"mean, {direction} (from {'below' if shift < 0 else 'above'})",
                zorder=3,
            )
    axes.set_xticks([each.reference_um_pp for each in found])
    axes.set_xlabel(quantity.headed("Reference"))
    axes.set_ylabel(quantity.headed("Match"))
    figure.legend(loc="outside lower center", ncols=2)
    return figure
