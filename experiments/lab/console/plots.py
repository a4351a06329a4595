"""Small plots as SVG elements: where points and bars stand, for a template to draw."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

WIDTH, HEIGHT = 640, 180
LEFT, BOTTOM, TOP = 56, 28, 10
MOST_POINTS = 2000  # of the newest runs; more would only be a band


@dataclass(frozen=True, slots=True)
class Scatter:
    """Points in a frame, in the SVG's units, and the labels of its axes."""

    points: tuple[tuple[float, float], ...]
    line: tuple[tuple[float, float], ...]
    ticks: tuple[tuple[float, str], ...]
    last: int


def scatter(series: Sequence[Sequence[float]]) -> Scatter | None:
    """Return response times of several runs over the trial's number, with the median of each.

    None where there are none. The largest times are drawn at the frame's top: 95 % of all points
    fix the scale.
    """
    rows = [(number, time) for times in series for number, time in enumerate(times, start=1)]
    rows = rows[-MOST_POINTS:]
    if not rows:
        return None
    last = max(number for number, _ in rows)
    ordered = sorted(time for _, time in rows)
    top = max(ordered[int(0.95 * (len(ordered) - 1))] * 1.15, 0.5)

    def x(number: float) -> float:
        return round(LEFT + (WIDTH - LEFT - 10) * (number - 0.5) / last, 1)

    def y(time: float) -> float:
        return round(HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * min(time / top, 1.0), 1)

    by_number: dict[int, list[float]] = {}
    for number, time in rows:
        by_number.setdefault(number, []).append(time)
    return Scatter(
        points=tuple((x(number), y(time)) for number, time in rows),
        line=tuple((x(number), y(median(times))) for number, times in sorted(by_number.items())),
        ticks=tuple((y(share * top), f"{share * top:.1f}") for share in (0.0, 0.5, 1.0)),
        last=last,
    )
