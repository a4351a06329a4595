"""Plot results across simulated studies: Table III cells, Fig. 15 curves, and other results."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slipscale.analysis.planning.distribution.distribution import Distribution
from slipscale.analysis.planning.distribution.numbers import cell_name
from slipscale.analysis.published import biet2007
from slipscale.analysis.writing.axes import amplitude_axis
from slipscale.figure_style import BLUE, GREY, PALE, VERMILION, canvas, styled

#: Titles for columns of Table III.
STATISTICS = {
    "mean": "Mean",
    "maximum_deviation": "Maximum deviation",
    "standard_deviation": "Standard deviation",
}
#: Maximum number of individual curves; more would merge into a band.
CURVES = 25
#: Maximum number of histograms, three per row.
PANELS = 12
COLUMNS = 3


@styled
def cells_figure(found: Distribution) -> Figure:
    """Plot the median and the 5 % and 95 % quantiles across studies for each Table III cell."""
    figure, panels = canvas(1, len(STATISTICS), size=(7.8, 3.4))
    amplitudes = np.array(found.levels)
    for axes, (statistic, title) in zip(panels, STATISTICS.items(), strict=True):
        for amplitude in amplitudes.tolist():
            cell = found.cell(amplitude, statistic)
            if cell is None:
                continue
            axes.plot([amplitude] * 2, [cell.p5, cell.p95], color=BLUE, linewidth=5, alpha=0.35,
                      solid_capstyle="butt")  # fmt: skip
            axes.plot(amplitude, cell.median, "o", color=BLUE, markersize=5.5)
        _paper(axes, found, statistic)
        axes.set_title(title)
        axes.set_ylim(bottom=0)
        amplitude_axis(axes, amplitudes, found.quantity)
        axes.set_xlabel(f"{found.quantity.title} ({found.quantity.unit_in_short})")
    panels[0].set_ylabel("Normalised estimate")
    return figure


def _paper(axes: Axes, found: Distribution, statistic: str) -> None:
    """Mark the published values if the study is the paper's experiment."""
    if found.study != biet2007.STUDY:
        return
    known = {amplitude: float(getattr(row, statistic)) for amplitude, row in
             biet2007.BY_AMPLITUDE.items() if amplitude in found.levels}  # fmt: skip
    axes.plot(
        list(known), list(known.values()), linestyle="none", marker="D", markersize=8,
        markerfacecolor="none", markeredgecolor=VERMILION, markeredgewidth=1.4,
    )  # fmt: skip


@styled
def curves_figure(found: Distribution) -> Figure:
    """Plot mean normalised estimates against the level, as in Fig. 15 of the paper.

    The figure shows the first `CURVES` studies, and the median and percentiles across all studies.
    """
    figure, axes = canvas(size=(5.6, 4.0))
    amplitudes = np.array(found.levels)
    names = [cell_name(amplitude, "mean") for amplitude in amplitudes.tolist()]
    for number, each in enumerate(found.results[:CURVES]):
        means = [each.found.numbers.get(name, np.nan) for name in names]
        label = f"single studies ({min(CURVES, len(found.results))})" if number == 0 else None
        axes.plot(amplitudes, means, color=PALE, linewidth=0.8, alpha=0.7, label=label)
    spreads = [found.by_name[name] for name in names]
    axes.fill_between(
        amplitudes,
        [spread.p5 for spread in spreads],
        [spread.p95 for spread in spreads],
        color=BLUE, alpha=0.15, linewidth=0, label="5th to 95th percentile of the studies",
    )  # fmt: skip
    medians = [spread.median for spread in spreads]
    axes.plot(amplitudes, medians, color=BLUE, marker="o", markersize=6, label="median")
    if found.study == biet2007.STUDY:
        _paper(axes, found, "mean")
        axes.plot([], [], linestyle="none", marker="D", markerfacecolor="none",
                  markeredgecolor=VERMILION, label="mean in the paper")  # fmt: skip
    amplitude_axis(axes, amplitudes, found.quantity)
    axes.set_ylabel("Mean normalised estimate")
    axes.set_ylim(bottom=0)
    axes.legend(loc="upper left")
    return figure


@styled
def results_figure(found: Distribution) -> Figure:
    """Plot a histogram of each main result that is not in Table III."""
    shown = found.headlines[:PANELS]
    columns = min(COLUMNS, len(shown))
    rows = -(-len(shown) // columns)
    figure, panels = canvas(rows, columns, size=(2.6 * columns + 0.4, 2.1 * rows), squeeze=False)
    for axes in panels.flat[len(shown) :]:
        axes.set_visible(False)
    for axes, (spread, words) in zip(panels.flat, shown, strict=False):
        axes.axvspan(spread.p5, spread.p95, color=BLUE, alpha=0.12, linewidth=0)
        axes.hist(found.values(spread.name), bins="auto", color=BLUE, alpha=0.75)
        axes.axvline(spread.median, color=GREY, linewidth=1.2)
        axes.set_title(words.replace(": ", ":\n"), fontsize=8.5)
        axes.set_yticks([])
        axes.locator_params(axis="x", nbins=4)
        axes.grid(visible=False)
    return figure
