"""Plot a scale from paired comparisons or triads."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from slipscale.analysis.reading.surface_labels import amplitude_of
from slipscale.analysis.writing.axes import tip
from slipscale.figure_style import BLUE, GREY, PALE, styled
from slipscale.stimuli.quantity import capitalised

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
    from slipscale.analysis.tasks.scales.statistics import TaskScale
    from slipscale.stimuli.quantity import Quantity


@styled
def scale(found: TaskScale, quantity: Quantity) -> Figure:
    """Plot a task's scale: Bradley-Terry for pairs, difference scale for triads."""
    figure = Figure(figsize=(5.6, 3.4), layout="constrained")
    axes = figure.add_subplot()
    for scaled, kind in (
        (found.bradley_terry, "log odds, Bradley-Terry"),
        (found.differences, "difference scale, 0 to 1"),
    ):
        if scaled:
            _points(axes, found.surfaces, scaled.values, scaled.intervals, quantity)
            axes.set_ylabel(f"{capitalised(quantity.judged)} ({kind})")
    return figure


def _points(
    axes: Axes,
    surfaces: Sequence[str],
    values: Sequence[float],
    intervals: Sequence[ConfidenceInterval | None],
    quantity: Quantity,
) -> None:
    numbers = [amplitude_of(name) for name in surfaces]
    known = [each for each in numbers if each is not None]
    # Textures have no position on an amplitude axis, so all surfaces are then drawn side by side.
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
    axes.set_xlabel(quantity.headed(quantity.title) if amplitudes else "Surface")
