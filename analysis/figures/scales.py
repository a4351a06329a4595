"""Figures of scales: surfaces from paired comparison and triads, and matches of references."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from slipscale.analysis.figures.shared import tip
from slipscale.analysis.reading.surface_labels import amplitude_of
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.figure_style import BLUE, GREY, INK, PALE, VERMILION, styled

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    from matplotlib.axes import Axes

    from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
    from slipscale.analysis.statistics.matching import MatchedReference
    from slipscale.analysis.statistics.scaling.task_scales import TaskScale


@styled
def scale(found: TaskScale) -> Figure:
    """Draw a task's scale: of pairs Bradley and Terry's, of triads the differences'."""
    figure = Figure(figsize=(5.6, 3.4), layout="constrained")
    axes = figure.add_subplot()
    if not isinstance(found.bradley_terry, NotComputed):
        scaled = found.bradley_terry
        _points(axes, found.surfaces, scaled.values, scaled.intervals)
        axes.set_ylabel("Slipperiness (log odds, Bradley-Terry)")
    elif not isinstance(found.differences, NotComputed):
        _points(axes, found.surfaces, found.differences.values, found.differences.intervals)
        axes.set_ylabel("Slipperiness (difference scale, 0 to 1)")
    return figure


def _points(
    axes: Axes,
    surfaces: Sequence[str],
    values: Sequence[float],
    intervals: Sequence[ConfidenceInterval | None],
) -> None:
    numbers = [amplitude_of(name) for name in surfaces]
    known = [each for each in numbers if each is not None]
    # Textures have no place on an axis of amplitudes: then all stand side by side.
    amplitudes = len(known) == len(surfaces)
    places = known if amplitudes else [float(place) for place in range(len(surfaces))]
    if amplitudes:
        axes.plot(places, values, color=PALE, linewidth=1.0, zorder=1)
    for place, name, value, interval in zip(places, surfaces, values, intervals, strict=True):
        if interval is not None:
            axes.plot([place, place], list(interval), color=BLUE, linewidth=1.8, zorder=2)
        axes.plot([place], [value], "o", color=BLUE, zorder=3, gid=tip(f"{name}: {value:.2f}"))
    axes.axhline(0, color=GREY, linewidth=0.8, linestyle=":", zorder=0)
    axes.set_xticks(places, list(surfaces))
    axes.set_xlabel("Amplitude (µm, peak to peak)" if amplitudes else "Surface")


@styled
def matches(found: Sequence[MatchedReference], trials: pd.DataFrame) -> Figure:
    """Draw matches against their references: participants, means from below and from above.

    Parameters
    ----------
    found : sequence of MatchedReference
        Of one task.
    trials : DataFrame
        `slipscale.analysis.reading.comparing_and_matching.read_matches`'s trials of the task.
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
    axes.set_xlabel("Reference (µm, peak to peak)")
    axes.set_ylabel("Match (µm, peak to peak)")
    figure.legend(loc="outside lower center", ncols=2)
    return figure
