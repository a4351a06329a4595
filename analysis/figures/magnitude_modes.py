"""Figures of ratings on a line, ratio judgements and magnitude production, with every person."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from slipscale.analysis.figures.shared import LINES_AT_MOST, apart, tip
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.ratings import cells
from slipscale.analysis.statistics.ratio_judgements import log_cells
from slipscale.analysis.statistics.regression import fit_lines
from slipscale.figure_style import BLUE, GREY, INK, PALE, styled

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
    from slipscale.analysis.statistics.productions import TaskProductions
    from slipscale.analysis.statistics.ratings import TaskRatings
    from slipscale.analysis.statistics.ratio_judgements import TaskRatios

    Array = NDArray[np.float64]

SIZE = (5.6, 3.9)


@styled
def ratings(found: TaskRatings, trials: pd.DataFrame) -> Figure:
    """Draw the line from 0 to 100: participants' mean ratings, and the means with intervals.

    Parameters
    ----------
    found : TaskRatings
    trials : DataFrame
        `slipscale.analysis.reading.magnitude_modes.read_ratings`'s trials of the task.
    """
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.add_subplot()
    main = trials[~trials["catch"]]
    table = cells(main)
    plain = main.loc[main["amplitude_um_pp"].notna(), "surface"].astype(str).unique()
    whole = set(table.columns) == set(plain)
    # Textures have no place on an axis of amplitudes: then all stand side by side.
    places = np.array(
        [float(name) for name in table.columns] if whole else range(len(table.columns)), float
    )
    _people(axes, places, table.to_numpy(float))
    _means(
        axes,
        places,
        [each.mean for each in found.surfaces],
        [each.interval for each in found.surfaces],
    )
    axes.set_ylim(-3, 103)
    for end in (0, 100):
        axes.axhline(end, color=GREY, linewidth=0.8, linestyle=":", zorder=0)
    axes.set_xticks(places, list(table.columns))
    if whole:
        shown = apart(axes, places)
        axes.set_xticks(shown, [f"{value:g}" for value in shown])
    axes.set_xlabel("Amplitude (µm, peak to peak)" if whole else "Surface")
    axes.set_ylabel("Place on the line (0 to 100)")
    return figure


@styled
def ratios(found: TaskRatios, trials: pd.DataFrame) -> Figure:
    """Draw ratios to the standard on logarithmic axes: participants, and geometric means."""
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.add_subplot()
    main = trials[~trials["catch"] & (trials["standard_um_pp"] == found.standard_um_pp)]
    table = log_cells(main, "comparison_um_pp", "ratio")
    table = table.loc[:, table.columns.to_numpy(float) > 0]  # 0 µm has no place on the axis
    shown = [each for each in found.surfaces if each.comparison_um_pp > 0]
    amplitudes = table.columns.to_numpy(float)
    _people(axes, amplitudes, np.exp(table.to_numpy(float)))
    means = [each.ratio for each in shown]
    _means(axes, amplitudes, means, [each.interval for each in shown])
    if not isinstance(found.power_law, NotComputed):
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
    _logarithmic(axes, np.append(amplitudes, found.standard_um_pp))
    axes.set_xlabel("Amplitude (µm, peak to peak)")
    axes.set_ylabel("Times as slippery as the standard")
    axes.legend(loc="lower right")
    return figure


@styled
def productions(found: TaskProductions, trials: pd.DataFrame) -> Figure:
    """Draw amplitudes produced against numbers, on logarithmic axes: participants, and means."""
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.add_subplot()
    table = log_cells(trials[~trials["catch"]], "number", "produced_um_pp")
    numbers = table.columns.to_numpy(float)
    _people(axes, numbers, np.exp(table.to_numpy(float)))
    means = [each.amplitude_um_pp for each in found.numbers]
    _means(axes, numbers, means, [each.interval for each in found.numbers])
    if not isinstance(found.slope, NotComputed):
        line = fit_lines(np.log(numbers), np.log(means))
        axes.plot(
            numbers, np.exp(line.intercept + line.slope * np.log(numbers)), color=BLUE, zorder=2
        )
    _standard(axes, found.modulus, found.standard_um_pp)
    _logarithmic(axes, np.append(numbers, found.modulus))
    axes.set_xlabel("Number shown")
    axes.set_ylabel("Amplitude produced (µm, peak to peak)")
    axes.legend(loc="lower right")
    return figure


def _people(axes: Axes, places: Array, values: Array) -> None:
    """Draw a pale line a participant."""
    for row in values[:LINES_AT_MOST]:
        axes.plot(places, row, "o-", color=PALE, linewidth=0.8, markersize=2.5, alpha=0.6, zorder=1)


def _means(
    axes: Axes,
    places: Array,
    means: Sequence[float],
    intervals: Sequence[ConfidenceInterval | None],
) -> None:
    for place, mean, interval in zip(places, means, intervals, strict=True):
        if interval is not None:
            axes.plot([place, place], list(interval), color=BLUE, linewidth=2.2, zorder=3)
        axes.plot([place], [mean], "o", color=BLUE, zorder=4, gid=tip(f"{place:g}: {mean:.3g}"))


def _standard(axes: Axes, x: float, y: float) -> None:
    axes.plot([x], [y], "D", color=INK, markersize=5, zorder=5, linewidth=0, label="standard")


def _logarithmic(axes: Axes, places: Array) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    ticks = apart(axes, np.unique(places))
    axes.set_xticks(ticks, [f"{value:g}" for value in ticks])
    axes.minorticks_off()
    axes.yaxis.set_major_formatter("{x:g}")
    low, high = axes.get_ylim()
    steps = [m * 10.0**p for p in range(-3, 4) for m in (1, 2, 5)]
    axes.set_yticks([step for step in steps if low <= step <= high])
