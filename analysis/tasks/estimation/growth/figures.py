"""Plot the growth of estimates with the stimulus."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.statistics.descriptives import student_intervals
from slipscale.analysis.statistics.power_law import exponents
from slipscale.analysis.tasks.estimation.growth.growth_models import MODELS
from slipscale.analysis.writing.axes import LINES_AT_MOST, apart
from slipscale.figure_style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PALE,
    PURPLE,
    VERMILION,
    canvas,
    styled,
)
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from slipscale.analysis.statistics.not_computed import NotComputed
    from slipscale.analysis.tasks.estimation.growth.statistics import Growth


@styled
def growth(
    logs: pd.DataFrame,
    found: Growth | NotComputed,
    *,
    unit: str = "% of the scale",
    confidence: float = 0.95,
    quantity: Quantity = PLATE_AMPLITUDE,
) -> Figure:
    """Plot growth functions on linear axes, and power functions on log-log axes.

    Parameters
    ----------
    logs : DataFrame, shape (participants, amplitudes)
        Mean natural logarithms of normalised estimates; estimates at 0 µm are omitted.
    found : Growth or NotComputed
        Result of `slipscale.analysis.tasks.estimation.growth.statistics.growth`.
    unit : str
        Unit of the estimates.
    confidence : float
        Confidence level of the t-based intervals around the geometric means.
    quantity : Quantity
        Quantity of the amplitudes.
    """
    # Panels are stacked, because panels side by side are illegible on a phone.
    figure, (left, right) = canvas(2, 1, size=(4.8, 6.8))
    above = logs.loc[:, logs.columns.to_numpy(float) > 0]
    amplitudes = above.columns.to_numpy(float)
    centre = above.mean().to_numpy(float)
    low, high = student_intervals(above, confidence)
    low, high = (np.where(np.isfinite(bound), bound, centre) for bound in (low, high))
    fine = np.linspace(amplitudes.min(), amplitudes.max(), 200)
    models = found.of_level.models if found else {}
    for (name, model), colour, dash in zip(
        models.items(),
        (BLUE, GREEN, ORANGE, PURPLE, GREY, VERMILION),
        ("-", (0, (1, 1.2)), (0, (5, 2)), "-.", (0, (3, 1, 1, 1, 1, 1)), (0, (8, 2))),
        strict=False,
    ):
        theta = MODELS[name].theta(model.fit.parameters)
        curve, points = (MODELS[name].log_f(x, theta) for x in (fine, amplitudes))
        left.plot(
            fine,
            np.exp(curve + (centre - points).mean()),
            color=colour,
            linestyle=dash,
            linewidth=1.8,
            label=name.replace("_", "-")
            + (f", ΔAICc {model.delta_aicc:.1f}" if model.delta_aicc is not None else ""),
            zorder=2,
        )
    for axes in (left, right):
        axes.errorbar(
            amplitudes,
            np.exp(centre),
            yerr=[np.exp(centre) - np.exp(low), np.exp(high) - np.exp(centre)],
            color=INK,
            linestyle="none",
            marker="o",
            markersize=5.5,
            elinewidth=1.5,
            capsize=3,
            zorder=4,
        )
        axes.set_xlabel(quantity.headed(quantity.title))
    left.set_ylabel(f"Geometric mean {quantity.judged}\n({unit})")
    left.set_xlim(left=0)
    left.set_ylim(bottom=0)
    left.set_title("Growth functions")
    if models:
        left.legend(loc="lower right")
    for row in np.exp(above.to_numpy(float))[:LINES_AT_MOST]:
        right.plot(amplitudes, row, color=PALE, linewidth=0.8, alpha=0.75, zorder=1)
    # The mean of participants' lines, because some participants may lack some amplitudes.
    mean = exponents(above).mean()
    right.plot(
        amplitudes,
        np.exp(mean["intercept"] + mean["exponent"] * np.log(amplitudes)),
        color=BLUE,
        linewidth=2,
        zorder=3,
    )
    right.set_xscale("log")
    right.set_yscale("log")
    ticks = apart(right, amplitudes)
    right.set_xticks(ticks, [f"{value:g}" for value in ticks])
    right.minorticks_off()
    right.yaxis.set_major_formatter("{x:g}")
    right.set_title(f"Logarithmic axes ({quantity.value(0)} omitted)")
    return figure
