"""Plot magnitude estimates and residuals."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator
from numpy.typing import NDArray

from slipscale.analysis.published import biet2007
from slipscale.analysis.statistics.descriptives import student_intervals, within_intervals
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


Parts = Iterator[tuple[str, pd.DataFrame, str]]


def _parts(table: pd.DataFrame, groups: pd.Series[str] | None) -> Parts:
    """Yield each group's name (empty without groups), its participants, and its colour."""
    parts = {"": table} if groups is None else dict(list(table.groupby(groups)))
    for number, (name, own) in enumerate(parts.items()):
        yield name and f" of {name}", own, (BLUE, VERMILION, GREEN, ORANGE, PURPLE)[number % 5]


def _means(
    axes: Axes,
    means: pd.Series[float],
    bounds: tuple[NDArray[np.float64], NDArray[np.float64]],
    *,
    label: str,
    interval: str,
    colour: str,
    quantity: Quantity,
    hollow: Collection[float] = (),
) -> None:
    """Draw means with their intervals and tooltips; missing intervals are omitted."""
    amplitudes, centre = means.index.to_numpy(float), means.to_numpy(float)
    low, high = bounds
    known = np.isfinite(low).any()
    axes.errorbar(
        amplitudes,
        centre,
        # Without bars, the legend has a line only.
        yerr=np.nan_to_num([centre - low, high - centre]) if known else None,
        color=colour,
        linewidth=2,
        capsize=3,
        elinewidth=1.6,
        zorder=4,
        label=f"{label}, {interval}" if known else label,
    )
    for amplitude, mean in zip(amplitudes, centre, strict=True):
        axes.plot(
            amplitude,
            mean,
            "o",
            color=colour,
            markersize=6.5,
            markerfacecolor="white" if amplitude in hollow else colour,
            clip_on=False,
            zorder=5,
            gid=tip(f"{quantity.value(amplitude)}: {label} {mean:.2f}"),
        )


@styled
def fig15(
    cells: pd.DataFrame,
    *,
    unit: str = "% of the scale",
    top: float | None = 100.0,
    most: float = np.inf,
    paper: bool = False,
    confidence: float = 0.95,
    quantity: Quantity = PLATE_AMPLITUDE,
    groups: pd.Series[str] | None = None,
) -> Figure:
    """Plot the paper's Fig. 15: arithmetic means on linear axes, with individual participants.

    Intervals end at possible means. The vertical axis contains them.

    Parameters
    ----------
    cells : DataFrame, shape (participants, amplitudes)
        Normalised mean estimates.
    unit : str
        Unit of the estimates.
    top : float, optional
        End of the vertical axis, unless values are larger. None if the scale has no fixed end.
    most : float
        Largest possible mean.
    paper : bool
        Whether to show the paper's means with one standard deviation, slightly to the right.
    confidence : float
        Confidence level of the t-based intervals.
    quantity : Quantity
        Quantity of the amplitudes.
    groups : Series, optional
        Group of each participant. If given, means are drawn separately for each group.
    """
    figure, axes = canvas(size=(5.6, 4.4))
    amplitudes = cells.columns.to_numpy(float)
    ends = [0.0 if top is None else top]
    for name, own, colour in _parts(cells, groups):
        bounds = np.clip(student_intervals(own, confidence), 0, most)
        ends += [
            float(np.nanmax(each)) for each in (own, bounds) if np.isfinite(each).any(axis=None)
        ]
        if len(cells) > 1:
            _individuals(axes, own, amplitudes, PALE if groups is None else colour)
        _means(
            axes,
            own.mean(),
            (bounds[0], bounds[1]),
            label=f"arithmetic mean{name}",
            interval=f"{100 * confidence:g} % CI",
            colour=colour,
            quantity=quantity,
        )
    amplitude_axis(axes, amplitudes, quantity)
    if paper:
        rows = [biet2007.BY_AMPLITUDE[amplitude] for amplitude in amplitudes]
        axes.errorbar(
            # Beside ours, so that neither hides the other.
            amplitudes + 0.02 * np.ptp(axes.get_xlim()),
            [float(row.mean) for row in rows],
            yerr=[float(row.standard_deviation) for row in rows],
            color=VERMILION,
            linestyle="none",
            marker="D",
            markersize=6.5,
            markerfacecolor="white",
            markeredgewidth=1.6,
            elinewidth=1,
            zorder=3,
            label="the paper\u2019s Table III: mean ± SD",
        )
    highest = max(ends)
    # Without a value above zero, any end is right.
    axes.set_ylim(0, (highest * (1.0 if highest == top else 1.05)) or 1.0)
    axes.set_ylabel(f"{capitalised(quantity.perceived)}\n({unit})")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


@styled
def growth_means(
    logs: pd.DataFrame,
    *,
    without_log: Collection[float] = (),
    unit: str = "% of the scale",
    confidence: float = 0.95,
    quantity: Quantity = PLATE_AMPLITUDE,
    groups: pd.Series[str] | None = None,
) -> Figure:
    """Plot geometric means of estimates on a logarithmic axis, with individual participants.

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
    for name, own, colour in _parts(logs, groups):
        if len(logs) > 1:
            _individuals(axes, own.map(np.exp), amplitudes, PALE if groups is None else colour)
        _means(
            axes,
            own.mean().map(np.exp),
            within_intervals(own, confidence),
            label=f"geometric mean{name}",
            interval=f"{100 * confidence:g} % within-participant CI",
            colour=colour,
            quantity=quantity,
            hollow=without_log,
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
