"""Plot the histogram and the cumulative distribution of a column's ratings over all data sets."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from slipscale.figure_style import BLUE, INK, canvas, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction_page.distributions import Bands

# Figures are narrow, so that the text is legible on a phone.
SIZE = (5.2, 2.5)


@styled
def histogram_figure(bands: Bands, ends: tuple[float, float]) -> Figure:
    """Plot a histogram of ratings that shows the variation across data sets.

    Each bar is the mean number of ratings across data sets. Lines show the 95 % band and the full
    range of this number. ``ends`` are the limits of the rating axis.
    """
    figure, axes = canvas(size=SIZE)
    middle, width = (bands.edges[1:] + bands.edges[:-1]) / 2, np.diff(bands.edges)
    axes.bar(middle, bands.mean, width=0.92 * width, color=BLUE, alpha=0.35, label="mean")
    axes.vlines(
        middle, bands.least, bands.most, color=INK, linewidth=0.8, label="smallest to largest"
    )
    axes.vlines(middle, bands.low, bands.high, color=BLUE, linewidth=3.2, label="95 % of data sets")
    axes.set(xlabel="Rating", ylabel="Participants", xlim=ends, ylim=(0, None))
    axes.legend(loc="upper left", bbox_to_anchor=(0, 1.18), ncols=3, frameon=False)
    return figure


@styled
def cumulative_figure(bands: Bands, ends: tuple[float, float]) -> Figure:
    """Plot the cumulative proportion of ratings, with its 95 % band and range across data sets."""
    figure, axes = canvas(size=SIZE)
    at = bands.edges

    def steps(values: Array) -> Array:
        return np.append(values, values[-1])

    axes.fill_between(
        at, steps(bands.least), steps(bands.most), step="post", color=INK, alpha=0.10,
        linewidth=0, label="smallest to largest",
    )  # fmt: skip
    axes.fill_between(
        at, steps(bands.low), steps(bands.high), step="post", color=BLUE, alpha=0.30,
        linewidth=0, label="95 % of data sets",
    )  # fmt: skip
    axes.step(at, steps(bands.mean), where="post", color=BLUE, label="mean")
    axes.set(xlabel="Rating", ylabel="Proportion up to the rating", xlim=ends, ylim=(0, 1.02))
    axes.legend(loc="upper left", bbox_to_anchor=(0, 1.18), ncols=3, frameon=False)
    return figure
