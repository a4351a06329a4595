"""Figures of magnitude estimates: Fig. 15, and the residuals of log estimates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from slipscale.analysis.published import biet2007
from slipscale.analysis.statistics import omnibus
from slipscale.analysis.statistics.descriptives import within_intervals
from slipscale.analysis.writing.axes import LINES_AT_MOST, amplitude_axis, over_decades, tip
from slipscale.figure_style import BLUE, INK, PALE, VERMILION, styled
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity, capitalised

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from numpy.typing import NDArray


def _individuals(axes: Axes, cells: pd.DataFrame, amplitudes: NDArray[np.float64]) -> None:
    """Draw each participant as a thin line; many as bands that hold 50 % and 90 % of them."""
    values = cells.to_numpy(float)
    if len(values) <= LINES_AT_MOST:
        for number, row in enumerate(values):
            axes.plot(
                amplitudes,
                row,
                color=PALE,
                linewidth=0.8,
                marker="o",
                markersize=3,
                markeredgewidth=0,
                alpha=0.75,
                clip_on=False,
                zorder=1,
                label="one participant" if number == 0 else None,
            )
        return
    low, q1, q3, high = np.nanquantile(values, [0.05, 0.25, 0.75, 0.95], axis=0)
    axes.fill_between(
        amplitudes, low, high, color="#E4E7EB", linewidth=0, label="90 % of participants"
    )
    axes.fill_between(
        amplitudes, q1, q3, color="#CBD2D9", linewidth=0, label="50 % of participants"
    )


def _geometric(
    axes: Axes, cells: pd.DataFrame, logs: pd.DataFrame, confidence: float, quantity: Quantity
) -> None:
    """Draw geometric means with within-participant intervals, where nobody is left out."""
    logs = logs.reindex(columns=cells.columns)
    low, high = within_intervals(logs, confidence)
    everybody = logs.notna().sum().to_numpy() == cells.notna().sum().to_numpy()
    here = everybody & np.isfinite(low)
    if not here.any():
        return
    centre = np.exp(logs.mean().to_numpy(float))
    amplitudes = cells.columns.to_numpy(float)
    # Beside the mean, which lies close by.
    beside = amplitudes + 0.018 * (float(np.ptp(amplitudes)) or 1.0)
    if over_decades(amplitudes, quantity):
        smallest = amplitudes[amplitudes > 0].min()
        beside = np.where(amplitudes > 0, 1.12 * amplitudes, 0.05 * smallest)
    axes.errorbar(
        beside[here],
        centre[here],
        yerr=[(centre - low)[here], (high - centre)[here]],
        color=INK,
        linestyle="none",
        marker="_",
        markersize=9,
        capsize=3,
        elinewidth=1.6,
        zorder=5,
        label=f"geometric mean, {100 * confidence:g} % within-participant interval",
    )


@styled
def fig15(
    cells: pd.DataFrame,
    logs: pd.DataFrame | None = None,
    *,
    unit: str = "% of the scale",
    confidence: float = 0.95,
    compare: bool = True,
    quantity: Quantity = PLATE_AMPLITUDE,
) -> Figure:
    """Draw the paper's Fig. 15: mean slipperiness against amplitude, with every participant.

    Parameters
    ----------
    cells : DataFrame, shape (participants, amplitudes)
        Normalised mean estimates.
    logs : DataFrame, shape (participants, amplitudes), optional
        Mean natural logarithms, for the geometric means and their intervals.
    unit : str
        The unit of the estimates.
    confidence : float
        Of the within-participant intervals (Cousineau-Morey, on logarithms).
    compare : bool
        Show the paper's means where the amplitudes are the paper's.
    quantity : Quantity
        What the amplitudes are.
    """
    figure = Figure(figsize=(5.6, 4.2), layout="constrained")
    axes = figure.add_subplot()
    amplitudes = cells.columns.to_numpy(float)
    alone = len(cells) == 1
    if not alone:
        _individuals(axes, cells, amplitudes)
    means = cells.mean().to_numpy(float)
    axes.plot(
        amplitudes,
        means,
        color=BLUE,
        linewidth=2,
        marker="o",
        markersize=6.5,
        zorder=4,
        label="the participant's mean" if alone else "mean",
    )
    for amplitude, mean in zip(amplitudes, means, strict=True):
        text = f"{quantity.value(amplitude)}: mean {mean:.2f}"
        axes.plot(amplitude, mean, "o", color=BLUE, markersize=6.5, zorder=4, gid=tip(text))
    if logs is not None:
        _geometric(axes, cells, logs, confidence, quantity)
    paper = biet2007.published_means()
    if compare and quantity.of_plate and set(amplitudes) <= set(paper):
        axes.plot(
            amplitudes,
            [paper[value] for value in amplitudes],
            linestyle="none",
            marker="D",
            markersize=8.5,
            markerfacecolor="none",
            markeredgecolor=VERMILION,
            markeredgewidth=1.6,
            zorder=5,
            label="mean in the paper (Table III)",
        )
    amplitude_axis(axes, amplitudes, quantity)
    axes.set_ylabel(f"{capitalised(quantity.perceived)}\n({unit})")
    axes.set_ylim(bottom=0)
    axes.legend(loc="upper left")
    return figure


@styled
def residuals(logs: pd.DataFrame, quantity: Quantity = PLATE_AMPLITUDE) -> Figure:
    """Draw residuals of participants' and amplitudes' means: against a normal, and by amplitude.

    Parameters
    ----------
    logs : DataFrame, shape (participants, amplitudes)
        Complete mean logarithms.
    quantity : Quantity
        What the amplitudes are.
    """
    from scipy import stats  # noqa: PLC0415 - a second's import

    figure = Figure(figsize=(5.6, 2.7), layout="constrained")
    left, right = figure.subplots(1, 2)
    left_over = omnibus.additive_residuals(logs.to_numpy(float))
    ordered = np.sort(left_over.ravel())
    expected = stats.norm.ppf((np.arange(ordered.size) + 0.5) / ordered.size) * ordered.std(ddof=1)
    shown = np.unique(np.linspace(0, ordered.size - 1, min(ordered.size, 400)).astype(int))
    span = [min(expected[0], ordered[0]), max(expected[-1], ordered[-1])]
    left.plot(span, span, color=PALE, linewidth=1.2, zorder=1)
    left.plot(expected[shown], ordered[shown], "o", color=BLUE, markersize=3.5, markeredgewidth=0)
    left.set_xlabel("Expected if normal")
    left.set_ylabel("Residual (natural logarithm)")
    left.set_title("Normality")
    amplitudes = logs.columns.to_numpy(float)
    right.axhline(0, color=PALE, linewidth=1.2)
    for amplitude, column in zip(amplitudes, left_over.T, strict=True):
        some = column[:: max(1, len(column) // 200)]
        right.plot(
            np.full(len(some), amplitude),
            some,
            "o",
            color=BLUE,
            markersize=3.5,
            markeredgewidth=0,
            alpha=0.6,
        )
    amplitude_axis(right, amplitudes, quantity)
    right.set_title(f"Spread at each {quantity.level}")
    return figure
