"""The parts of a run as bars in time, with the spread over people."""

from __future__ import annotations

from typing import TYPE_CHECKING

from figure_style import BLUE, INK, canvas, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from experiments.running.timeline import Timeline


@styled
def timeline_figure(found: Timeline) -> Figure:
    """Return a bar for each part: the median's minutes, and from p5 to p95 as a line."""
    rows = [*found.parts, ("in all", found.total_min), ("plate vibrating", found.plate_on_min)]
    figure, axes = canvas(size=(6.6, 0.9 + 0.42 * len(rows)))
    places = range(len(rows))
    axes.barh(places, [spread.p50 for _, spread in rows], height=0.55, color=BLUE, alpha=0.45)
    axes.hlines(
        places, [spread.p5 for _, spread in rows], [spread.p95 for _, spread in rows], color=INK
    )
    for place, (_, spread) in zip(places, rows, strict=True):
        axes.annotate(
            f" {spread.p50:.1f}", (spread.p95, place), va="center", fontsize=8.5, color=INK
        )
    axes.set_yticks(places, [name for name, _ in rows])
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.grid(axis="x", visible=True)
    longest = max(spread.p95 for _, spread in rows)
    axes.set(xlabel="Minutes (median; line: 5 % to 95 % of people)", xlim=(0, 1.1 * longest))
    return figure
