"""Plot power against sample size, and precision against the study design."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.planning.power.answers import Row, varying
from slipscale.analysis.planning.power.yes_no_steps import CATCH_WIDTH, D_PRIME_LOW
from slipscale.figure_style import CYCLE, DASHES, GREY, canvas, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure


#: Maximum number of distinguishable curves.
CURVES = 8
#: Line styles, for greyscale prints.
MARKERS = "os^D"


@styled
def power_figure(found: Sequence[Row], target: float) -> Figure:
    """Plot the power of the weakest comparison against sample size, one curve per condition."""
    figure, axes = canvas(size=(6.6, 4.0))
    others = [axis for axis in varying(found) if axis != "participants"]
    curves: dict[str, list[Row]] = {}
    for row in found:
        name = row.condition.described(others)
        curves.setdefault(name, []).append(row)
    for number, (name, own) in enumerate(list(curves.items())[:CURVES]):
        colour, dash = CYCLE[number % len(CYCLE)], DASHES[number // len(CYCLE) % len(DASHES)]
        sizes = [row.condition.participants for row in own]
        shares = [row.weakest for row in own]
        axes.fill_between(
            sizes,
            [share.low for share in shares],
            [share.high for share in shares],
            color=colour,
            alpha=0.18,
            linewidth=0,
        )
        values = [share.value for share in shares]
        marker = MARKERS[number % len(MARKERS)]
        axes.plot(sizes, values, dash, marker=marker, markersize=4, color=colour, label=name)
    axes.axhline(target, color=GREY, linewidth=0.9, linestyle=":")
    axes.annotate(
        f"target {target:g}", (0.01, target), xycoords=("axes fraction", "data"), fontsize=8,
        color=GREY, ha="left", va="bottom",
    )  # fmt: skip
    axes.set(xlabel="Participants", ylabel="Power of the weakest comparison", ylim=(0, 1.02))
    if others:
        # The legend is placed above the axes, because curves may cross any part of the plot.
        figure.legend(loc="outside upper left", ncols=2, handlelength=3.5)
    if len(curves) > CURVES:
        axes.set_title(
            f"Only the first {CURVES} of {len(curves)} conditions are shown", fontsize=8.5
        )
    return figure


@styled
def catch_figure(found: Sequence[Row]) -> Figure:
    """Plot precision against the number of catch steps, with one curve per sample size."""
    figure, panels = canvas(1, 2, size=(6.6, 3.2), sharex=True)
    first = found[0].condition
    axes_left = [axis for axis in varying(found) if axis not in ("participants", "catch_steps")]
    same = [
        row
        for row in found
        if all(getattr(row.condition, axis) == getattr(first, axis) for axis in axes_left)
    ]
    sizes = sorted({row.condition.participants for row in same})[:CURVES]
    titles = {
        CATCH_WIDTH: 'Half-width of the interval for\nthe proportion of "yes" at catch steps',
        D_PRIME_LOW: "Lower bound of d'",
    }
    for axes, (name, title) in zip(panels, titles.items(), strict=True):
        for number, size in enumerate(sizes):
            own = [row for row in same if row.condition.participants == size]
            values = np.array([row.steps[name].mean for row in own])
            errors = 1.96 * np.array([row.steps[name].error for row in own])
            steps = [row.condition.catch_steps for row in own]
            colour = CYCLE[number % len(CYCLE)]
            dash = DASHES[number // len(CYCLE) % len(DASHES)]
            axes.fill_between(
                steps, values - errors, values + errors, color=colour, alpha=0.18, linewidth=0
            )
            marker = MARKERS[number % len(MARKERS)]
            axes.plot(
                steps, values, dash, marker=marker, markersize=4, color=colour,
                label=f"{size} participants",
            )  # fmt: skip
        axes.set(xlabel="Catch steps in each series", ylabel=title, ylim=(0, None))
        axes.set_xticks(sorted({row.condition.catch_steps or 0 for row in same}))
    if len(sizes) > 1:
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=min(len(sizes), 4))
    return figure


@styled
def precision_figure(found: Sequence[Row]) -> Figure:
    """Plot a map of the exponent interval's half-width against sample size and repetitions."""
    figure, axes = canvas(size=(6.6, 3.6))
    # Only one value of each other option can be shown: the first condition with the largest effect.
    first = max(found, key=lambda row: row.condition.effect).condition
    same = [
        row
        for row in found
        if all(
            getattr(row.condition, axis) == getattr(first, axis)
            for axis in varying(found)
            if axis not in ("participants", "repetitions")
        )
    ]
    sizes = sorted({row.condition.participants for row in same})
    repetitions = sorted({row.condition.repetitions for row in same})
    table = np.full((len(repetitions), len(sizes)), np.nan)
    for row in same:
        place = (
            repetitions.index(row.condition.repetitions),
            sizes.index(row.condition.participants),
        )
        table[place] = row.widths["exponent"].mean
    image = axes.imshow(table, aspect="auto", origin="lower", cmap="cividis_r")
    for (y, x), value in np.ndenumerate(table):
        if np.isfinite(value):
            dark = value < np.nanmean(table)
            axes.annotate(
                f"{value:.3f}", (x, y), ha="center", va="center", fontsize=8.5,
                color="#000000" if dark else "#FFFFFF",
            )  # fmt: skip
    axes.grid(visible=False)
    axes.set_xticks(range(len(sizes)), [str(size) for size in sizes])
    axes.set_yticks(range(len(repetitions)), [str(number) for number in repetitions])
    others = [axis for axis in varying(found) if axis not in ("participants", "repetitions")]
    axes.set_title(first.described(others), fontsize=8.5)
    axes.set(xlabel="Participants", ylabel="Ratings per surface")
    bar = figure.colorbar(image, ax=axes)
    bar.set_label("Half-width of the exponent's interval")
    return figure
