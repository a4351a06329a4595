"""Compute the coordinates of small SVG plots for the templates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import NamedTuple

from slipscale.experiments.lab.curves import Curve
from slipscale.stimuli.surface import Surface

MOST_POINTS = 2000  # most points, from the newest runs; more would merge into a band


class Frame(NamedTuple):
    """Edges of a plot's frame, in SVG units."""

    left: float
    right: float
    top: float
    bottom: float

    def x(self, across: float) -> float:
        """Return the x coordinate at a fraction of the width (0: left edge, 1: right edge)."""
        return round(self.left + (self.right - self.left) * across, 1)

    def y(self, up: float) -> float:
        """Return the y coordinate at a fraction of the height (0: lower edge, 1: upper edge)."""
        return round(self.bottom - (self.bottom - self.top) * up, 1)


#: Frames for plots of 640 by 180 SVG units (response times; live and planning curves) and for
#: small plots of 160 by 90.
TIMES, WIDE, SMALL = Frame(56, 630, 10, 152), Frame(48, 630, 10, 152), Frame(8, 152, 8, 82)


@dataclass(frozen=True, slots=True)
class Scatter:
    """A scatter plot: SVG coordinates of its points, its line and its tick labels."""

    points: tuple[tuple[float, float], ...]
    line: tuple[tuple[float, float], ...]
    ticks: tuple[tuple[float, str], ...]
    last: int


def scatter(series: Sequence[Sequence[float]]) -> Scatter | None:
    """Plot the response times of several runs against trial number, with the median per trial.

    Returns None if there are no response times. The scale is determined by the 95th percentile;
    times that exceed the scale are drawn at the frame's top edge.
    """
    rows = [(number, time) for times in series for number, time in enumerate(times, start=1)]
    rows = rows[-MOST_POINTS:]
    if not rows:
        return None
    last = max(number for number, _ in rows)
    ordered = sorted(time for _, time in rows)
    top = max(ordered[int(0.95 * (len(ordered) - 1))] * 1.15, 0.5)

    def x(number: float) -> float:
        return TIMES.x((number - 0.5) / last)

    def y(time: float) -> float:
        return TIMES.y(min(time / top, 1.0))

    by_number: dict[int, list[float]] = {}
    for number, time in rows:
        by_number.setdefault(number, []).append(time)
    return Scatter(
        points=tuple((x(number), y(time)) for number, time in rows),
        line=tuple((x(number), y(median(times))) for number, times in sorted(by_number.items())),
        ticks=tuple((y(share * top), f"{share * top:.1f}") for share in (0.0, 0.5, 1.0)),
        last=last,
    )


@dataclass(frozen=True, slots=True)
class Drawing:
    """A surface drawn as an SVG path in a 120 by 48 frame, with a caption."""

    path: str
    label: str


def drawing(surface: Surface, largest: float, label: str) -> Drawing:
    """Draw the plate's vibration for a plain surface, or the level profile of a texture.

    Heights are relative to the level ``largest``.
    """
    heights = [surface.shown(x / 120) / largest for x in range(121)]
    points = " ".join(f"{x},{24 - 21 * height:.1f}" for x, height in enumerate(heights))
    return Drawing(f"M {points}", label)


@dataclass(frozen=True, slots=True)
class CurvePlot:
    """A participant's curve as SVG points in a 160 by 90 frame, with the limits of both axes."""

    curve: Curve
    title: str
    points: tuple[tuple[float, float], ...]
    x_ends: tuple[str, str]
    y_ends: tuple[str, str]


def curve_plot(curve: Curve, group: Sequence[Curve], title: str) -> CurvePlot:
    """Draw a curve with axes shared by all curves in its group."""
    xs = [x for each in group for x, _ in each.points]
    ys = [y for each in group for _, y in each.points]
    left, right, low, high = min(xs), max(xs), min(0.0, *ys), max(ys)

    def place(x: float, y: float) -> tuple[float, float]:
        across = (x - left) / (right - left or 1.0)
        up = (y - low) / (high - low or 1.0)
        return SMALL.x(across), SMALL.y(up)

    ends = (f"{left:g}", f"{right:g}"), (f"{low:.3g}", f"{high:.3g}")
    return CurvePlot(curve, title, tuple(place(*point) for point in curve.points), *ends)
