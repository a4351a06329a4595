"""Plot a participant's timeline: minutes per part, plate limits and cost."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from slipscale.figure_style import BLUE, INK, VERMILION, canvas, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from slipscale.experiments.running.timeline import Spread, Timeline


@styled
def timeline_figure(found: Timeline) -> Figure:
    """Plot the minutes per part, the plate's use relative to its limits and any known cost."""
    minutes = [*found.parts, ("in all", found.total_min), ("plate vibrating", found.plate_on_min)]
    heights = [len(minutes), 2.0, *([4.5] if found.cost_total else [])]
    figure, panels = canvas(
        len(heights),
        1,
        size=(6.6, 1.0 + 0.42 * sum(heights) + 0.6 * len(heights)),
        gridspec_kw={"height_ratios": heights},
    )
    _bars(panels[0], minutes, digits=1)
    panels[0].set_xlabel("Minutes (bar: median; line: 5th to 95th percentile)")
    exposures = found.exposures.p50
    limits = [
        (f"longest vibration\n(limit {found.on_time_limit_s:g} s)", found.longest_on_s,
         found.on_time_limit_s),
        (f"largest duty cycle\n(limit {100 * found.duty_limit:.0f} %)", found.duty,
         found.duty_limit),
    ]  # fmt: skip
    shares = [(name, _scaled(spread, 100 / limit)) for name, spread, limit in limits]
    _bars(panels[1], shares, digits=0, least=110.0)
    panels[1].axvline(100, color=VERMILION, linestyle="--", linewidth=1.2)
    panels[1].set_xlabel(f"% of the plate's limit ({exposures:.0f} vibrating surfaces)")
    if found.cost_total:
        _cost(panels[2], found, found.cost_total)
    return figure


def _scaled(spread: Spread, factor: float) -> Spread:
    return type(spread)(p5=factor * spread.p5, p50=factor * spread.p50, p95=factor * spread.p95)


def _bars(axes: Axes, rows: list[tuple[str, Spread]], *, digits: int, least: float = 0.0) -> None:
    """Draw the median of each row as a bar, and the range from p5 to p95 as a line."""
    places = range(len(rows))
    axes.barh(places, [spread.p50 for _, spread in rows], height=0.55, color=BLUE, alpha=0.45)
    axes.hlines(
        places, [spread.p5 for _, spread in rows], [spread.p95 for _, spread in rows], color=INK
    )
    for place, (_, spread) in zip(places, rows, strict=True):
        axes.annotate(
            f" {spread.p50:.{digits}f}", (spread.p95, place), va="center", fontsize=8.5, color=INK
        )
    axes.set_yticks(places, [name for name, _ in rows])
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.grid(axis="y", visible=False)
    axes.grid(axis="x", visible=True)
    axes.set_xlim(0, max(1.1 * max(spread.p95 for _, spread in rows), least))


def _cost(axes: Axes, found: Timeline, total: Spread) -> None:
    """Plot the total cost against the number of participants, and mark the planned number.

    The spread of the total cost is proportional to the square root of the number of participants.
    """
    planned = found.participants
    people = np.arange(2 * planned + 1)
    middle, root = total.p50 * people / planned, np.sqrt(people / planned)
    axes.fill_between(
        people,
        middle - (total.p50 - total.p5) * root,
        middle + (total.p95 - total.p50) * root,
        color=BLUE,
        alpha=0.25,
        linewidth=0,
    )
    axes.plot(people, middle, color=BLUE)
    axes.plot([planned], [total.p50], "o", color=INK)
    axes.annotate(
        f"{planned} planned:\n{total.p50:.0f} {found.currency}",
        (planned, total.p50),
        xytext=(8, -4),
        textcoords="offset points",
        ha="left",
        va="top",
        color=INK,
        fontsize=8.5,
    )
    axes.set(
        xlabel="Number of participants (band: 5th to 95th percentile)",
        ylabel=f"Cost, {found.currency}",
        xlim=(0, 2 * planned),
        ylim=(0, None),
    )
