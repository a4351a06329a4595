"""Plot magnitude estimates and residuals."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator
from numpy.typing import NDArray

from slipscale.analysis.published import biet2007
from slipscale.analysis.statistics.descriptives import within_intervals
from slipscale.analysis.statistics.repeated_measures import omnibus
from slipscale.analysis.writing.axes import LINES_AT_MOST, amplitude_axis, tip
from slipscale.figure_style import BLUE, GREEN, ORANGE, PALE, PURPLE, VERMILION, canvas, styled
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity, capitalised


def _individuals(
    axes: Axes, cells: pd.DataFrame, amplitudes: NDArray[np.float64], colour: str = PALE
) -> None:
    """Draw one thin line per participant, or 50 % and 90 % bands if there are many."""
    values = cells.to_numpy(float)
    if len(values) <= LINES_AT_MOST:
        for number, row in enumerate(values):
            axes.plot(
                amplitudes,
                row,
                color=colour,
                linewidth=0.8,
                marker="o",
                markersize=3,
                markeredgewidth=0,
                alpha=0.75 if colour == PALE else 0.3,
                clip_on=False,
                zorder=1,
                label="one participant" if number == 0 and colour == PALE else None,
            )
        return
    low, q1, q3, high = np.nanquantile(values, [0.05, 0.25, 0.75, 0.95], axis=0)
    for share, bottom, top, alpha in ((90, low, high, 0.2), (50, q1, q3, 0.25)):
        named = f"{share} % of participants" if colour == PALE else None
        axes.fill_between(
            amplitudes, bottom, top, color=colour, alpha=alpha, linewidth=0, zorder=0, label=named
        )


@styled
def fig15(
    logs: pd.DataFrame,
    *,
    without_log: Collection[float] = (),
    unit: str = "% of the scale",
    confidence: float = 0.95,
    quantity: Quantity = PLATE_AMPLITUDE,
    groups: pd.Series[str] | None = None,
) -> Figure:
    """Plot geometric means of estimates against amplitude, with individual participants.

    Individual lines are drawn after modulus equalisation (Lane, Catania and Stevens 1961): each
    participant's logarithms are shifted to the mean of all participants or of the group, which does
    not change the geometric means.

    Parameters
    ----------
    logs : DataFrame, shape (participants, amplitudes)
        Mean natural logarithms of normalised estimates.
    without_log : collection of float
        Amplitudes at which estimates of zero were omitted. Their means are drawn as hollow markers.
    unit : str
        Unit of the estimates.
    confidence : float
        Confidence level of the within-participant intervals.
    quantity : Quantity
        Quantity of the amplitudes.
    groups : Series, optional
        Group of each participant. If given, means are drawn separately for each group.
    """
    figure, axes = canvas(size=(5.6, 4.2))
    amplitudes = logs.columns.to_numpy(float)
    parts = {"": logs} if groups is None else dict(list(logs.groupby(groups)))
    for number, (name, own) in enumerate(parts.items()):
        colour = (BLUE, VERMILION, GREEN, ORANGE, PURPLE)[number % 5]
        if len(logs) > 1:
            # Participants' means are computed relative to the means of amplitudes, so that a
            # missing amplitude does not shift a participant's line.
            equalised = own.sub(own.sub(own.mean()).mean(axis=1), axis=0)
            _individuals(
                axes, equalised.map(np.exp), amplitudes, PALE if groups is None else colour
            )
        centre = np.exp(own.mean().to_numpy(float))
        low, high = within_intervals(own, confidence)
        axes.errorbar(
            amplitudes,
            centre,
            yerr=np.nan_to_num([centre - low, high - centre]),
            color=colour,
            linewidth=2,
            capsize=3,
            elinewidth=1.6,
            zorder=4,
            label=f"geometric mean{f' of {name}' if name else ''}",
        )
        for amplitude, mean in zip(amplitudes, centre, strict=True):
            axes.plot(
                amplitude,
                mean,
                "o",
                color=colour,
                markersize=6.5,
                markerfacecolor="white" if amplitude in without_log else colour,
                zorder=5,
                gid=tip(f"{quantity.value(amplitude)}: geometric mean {mean:.2f}"),
            )
    if without_log:
        axes.plot([], "o", color=BLUE, markerfacecolor="white", label="without estimates of zero")
    # Axis limits are set explicitly, because Matplotlib cannot choose logarithmic limits for a
    # single value.
    axes.set_ylim(axes.dataLim.y0 / 1.2, axes.dataLim.y1 * 1.2)
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(base=10, subs=(1, 2, 5)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter("{x:g}")
    amplitude_axis(axes, amplitudes, quantity)
    axes.set_ylabel(f"{capitalised(quantity.perceived)}\n({unit})")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


@styled
def arithmetic_means(
    cells: pd.DataFrame,
    *,
    unit: str = "% of the scale",
    quantity: Quantity = PLATE_AMPLITUDE,
) -> Figure:
    """Plot arithmetic means as in the paper's Fig. 15, next to the published values.

    Parameters
    ----------
    cells : DataFrame, shape (participants, amplitudes)
        Normalised mean estimates.
    unit : str
        Unit of the estimates.
    quantity : Quantity
        Quantity of the amplitudes.
    """
    figure, axes = canvas(size=(5.6, 3.6))
    amplitudes = cells.columns.to_numpy(float)
    if len(cells) > 1:
        _individuals(axes, cells, amplitudes)
    axes.plot(
        amplitudes,
        cells.mean().to_numpy(float),
        color=BLUE,
        linewidth=2,
        marker="o",
        markersize=6.5,
        zorder=4,
        label="arithmetic mean",
    )
    if biet2007.covers(cells.columns, quantity):
        paper = biet2007.published_means()
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
    """Plot residuals in a normal quantile plot and against amplitude.

    Parameters
    ----------
    logs : DataFrame, shape (participants, amplitudes)
        Complete mean logarithms.
    quantity : Quantity
        Quantity of the amplitudes.
    """
    from scipy import stats

    figure, (left, right) = canvas(1, 2, size=(5.6, 2.7))
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
