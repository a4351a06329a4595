"""Plot a scale from paired comparison or triads."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from slipscale.analysis.tasks.scales.surface_labels import amplitude_of
from slipscale.analysis.writing.axes import tip
from slipscale.figure_style import BLUE, GREY, PALE, styled

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
    from slipscale.analysis.tasks.scales.statistics import TaskScale


@styled
def scale(found: TaskScale) -> Figure:
    """Plot a task's scale: Bradley and Terry's for pairs, the difference scale for triads."""
    figure = Figure(figsize=(5.6, 3.4), layout="constrained")
    axes = figure.add_subplot()
    if found.bradley_terry:
        scaled = found.bradley_terry
        _points(axes, found.surfaces, scaled.values, scaled.intervals)
        axes.set_ylabel("Slipperiness (log odds, Bradley-Terry)")
    elif found.differences:
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
    # Textures have no position on an axis of amplitudes; all surfaces are then drawn side by
    # side.
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
