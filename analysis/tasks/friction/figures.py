"""Plot ratings against the friction measured under the finger."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from slipscale.analysis.statistics.measured_friction import used_trials
from slipscale.analysis.writing.axes import LINES_AT_MOST
from slipscale.experiments.dataset.measured import COEFFICIENT
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.figure_style import BLUE, GREY, INK, PALE, styled

if TYPE_CHECKING:
    from slipscale.analysis.preprocessing.log_transform import Prepared


@styled
def rating_friction(prepared: Prepared, *, unit: str) -> Figure:
    """Draw each participant's estimates against their measured coefficients of friction.

    Parameters
    ----------
    prepared : Prepared
    unit : str
        Unit of the estimates.
    """
    figure = Figure(figsize=(4.8, 3.8), layout="constrained")
    axes = figure.subplots()
    trials = used_trials(prepared)
    axes.scatter(
        trials[COEFFICIENT], np.exp(trials["log"]), s=9, color=PALE, linewidths=0, zorder=1
    )
    by_surface = trials.groupby([PARTICIPANT, "amplitude_um_pp"], observed=True)
    means = by_surface[[COEFFICIENT, "log"]].mean()
    people = means.groupby(level=0, observed=True)
    for _, own in people if len(people) <= LINES_AT_MOST else ():
        order = own.sort_values(COEFFICIENT)
        axes.plot(
            order[COEFFICIENT], np.exp(order["log"]), color=GREY, linewidth=0.8, alpha=0.7, zorder=2
        )
    surfaces = means.groupby(level=1).mean().sort_values(COEFFICIENT)
    axes.plot(
        surfaces[COEFFICIENT],
        np.exp(surfaces["log"]),
        color=BLUE,
        marker="o",
        markersize=6,
        markeredgecolor=INK,
        linewidth=2,
        zorder=3,
    )
    for amplitude, place in surfaces.iterrows():
        axes.annotate(
            f"{amplitude:g} µm",
            (place[COEFFICIENT], np.exp(place["log"])),
            xytext=(6, 6),
            textcoords="offset points",
            fontsize=8,
            color=INK,
            zorder=4,
        )
    axes.set_yscale("log")
    axes.set_xlabel("measured coefficient of friction")
    axes.set_ylabel(f"estimate of slipperiness\n({unit})")
    return figure
