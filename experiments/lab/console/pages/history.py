"""Draw the plate's history during a run: readback deviation, temperature and faults.

To keep the operator blind, only the largest and the median deviation in each complete group of
eight presentations are shown: the deviation of a single presentation could reveal its amplitude.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING

from slipscale.experiments.lab.console.plots import TIMES

if TYPE_CHECKING:
    from slipscale.experiments.lab.blind_summary import PlateReading, RunSummary

TOGETHER = 8
LEAST_SPAN_C = 2.0  # least range of the temperature axis, so that noise does not look like a rise


@dataclass(frozen=True, slots=True, kw_only=True)
class Deviation:
    """Readback deviation in eight consecutive presentations, as a fraction of the allowed one."""

    begin_s: float
    end_s: float
    largest: float
    median: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Bar:
    """A bar that represents a group of presentations, in SVG units."""

    x: float
    width: float
    top: float
    middle: float


@dataclass(frozen=True, slots=True, kw_only=True)
class History:
    """Elements of the plotted history, in SVG units.

    Parameters
    ----------
    bars : tuple of Bar
        Readback deviations.
    limit : float
        y coordinate of the line at the largest allowed deviation.
    warmth : tuple of (float, float)
        Temperature over time; empty if the plate does not report its temperature.
    warmth_ticks : tuple of (float, str)
        Ticks of the temperature axis, in °C.
    faults : tuple of float
        x coordinates of the times at which faults occurred.
    minutes : float
        End of the time axis.
    """

    bars: tuple[Bar, ...]
    limit: float
    warmth: tuple[tuple[float, float], ...]
    warmth_ticks: tuple[tuple[float, str], ...]
    faults: tuple[float, ...]
    minutes: float


def deviations(readings: Sequence[PlateReading]) -> list[Deviation]:
    """Return the largest and the median deviation in each group of eight presentations."""
    measured = [
        (reading.time_s, reading.used_tolerance)
        for reading in readings
        if reading.used_tolerance is not None
    ]
    ends = range(TOGETHER, len(measured) + 1, TOGETHER)
    whole = [measured[end - TOGETHER : end] for end in ends]
    return [
        Deviation(
            begin_s=group[0][0],
            end_s=group[-1][0],
            largest=max(used for _, used in group),
            median=median(used for _, used in group),
        )
        for group in whole
    ]


def history(run: RunSummary) -> History | None:
    """Return the plate's history during a run; None if there is nothing to draw yet."""
    groups = deviations(run.readings)
    warm = [(r.time_s, r.temperature_c) for r in run.readings if r.temperature_c is not None]
    faults_s = [event.time_s for event in run.events if event.kind == "fault"]
    if not groups and len(warm) < 2 and not faults_s:  # noqa: PLR2004 - one point is no line
        return None
    end_s = max(run.duration_s, *(time_s for time_s, _ in warm), *faults_s, 60.0)
    top = max(1.15, *(group.largest for group in groups)) if groups else 1.15
    middle_c = sum(c for _, c in warm) / len(warm) if warm else 0.0
    low_c = min((c for _, c in warm), default=0.0)
    high_c = max((c for _, c in warm), default=0.0)
    if high_c - low_c < LEAST_SPAN_C:
        low_c, high_c = middle_c - LEAST_SPAN_C / 2, middle_c + LEAST_SPAN_C / 2

    def x(time_s: float) -> float:
        return TIMES.x(time_s / end_s)

    return History(
        bars=tuple(
            Bar(
                x=x(group.begin_s),
                width=max(x(group.end_s) - x(group.begin_s) - 2, 2.0),
                top=TIMES.y(group.largest / top),
                middle=TIMES.y(group.median / top),
            )
            for group in groups
        ),
        limit=TIMES.y(1 / top),
        warmth=tuple((x(time_s), TIMES.y((c - low_c) / (high_c - low_c))) for time_s, c in warm),
        warmth_ticks=tuple(
            (TIMES.y(share), f"{low_c + share * (high_c - low_c):.1f}") for share in (0.0, 1.0)
        ),
        faults=tuple(x(time_s) for time_s in faults_s),
        minutes=round(end_s / 60, 1),
    )
