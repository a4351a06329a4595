"""What an exploration's samples say: how fast, how many strokes, how much friction. Pure.

Speed and strokes are taken from places some 50 ms apart: between neighbouring samples a sensor's
noise would pass for movement.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass
from itertools import pairwise
from statistics import fmean, median
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.hardware.contact.source import Sample

APART_S = 0.05
LONGEST_GAP_S = 0.5  # longer, and the finger was lifted meanwhile
STROKE_MM = 5.0  # a stroke is at least so long: less is a tremble
MOVES_MM_S = 10.0  # slower, and the finger may stick
PRESSES_N = 0.05  # less, and the finger may be off the plate
FEWEST = 10  # samples of sliding for a coefficient


@dataclass(frozen=True, slots=True, kw_only=True)
class Movement:
    """How a finger moved.

    Parameters
    ----------
    speed_mm_s : float or None
        Length of its way divided by the time that it touched; None where it was never seen twice.
    strokes : int
        How often it went one way along x for 5 mm or more.
    """

    speed_mm_s: float | None
    strokes: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Friction:
    """What was measured of the forces while the finger slid.

    Parameters
    ----------
    coefficient : float or None
        Median of the size of the lateral force divided by the normal one.
    normal_n : float or None
        Mean normal force.
    """

    coefficient: float | None
    normal_n: float | None


def movement(samples: Sequence[Sample]) -> Movement:
    """Return how a finger moved, from samples of x and y in mm."""
    kept = apart(samples)
    way_mm = time_s = 0.0
    for before, after in pairwise(kept):
        gap_s = after.time_s - before.time_s
        if gap_s <= LONGEST_GAP_S:
            way_mm += math.dist(before.values, after.values)
            time_s += gap_s
    return Movement(
        speed_mm_s=way_mm / time_s if time_s > 0 else None,
        strokes=_strokes([each.values[0] for each in kept]),
    )


def friction(forces: Sequence[Sample], places: Sequence[Sample] = ()) -> Friction:
    """Return the friction while the finger slid.

    Parameters
    ----------
    forces : sequence of Sample
        Normal and lateral force, N.
    places : sequence of Sample
        Where the finger was, if that is known: only what was measured while it moved along x
        counts. Otherwise all that was measured while it pressed does.
    """
    pressed = [each for each in forces if each.values[0] >= PRESSES_N]
    slid = [each for each in pressed if _moves(places, each.time_s)] if places else pressed
    if len(slid) < FEWEST:
        return Friction(coefficient=None, normal_n=None)
    return Friction(
        coefficient=median(abs(each.values[1]) / each.values[0] for each in slid),
        normal_n=fmean(each.values[0] for each in slid),
    )


def apart(samples: Sequence[Sample]) -> list[Sample]:
    """Return the first sample and each that comes 50 ms or more after the one before."""
    kept: list[Sample] = []
    for each in samples:
        if not kept or each.time_s - kept[-1].time_s >= APART_S - 1e-9:
            kept.append(each)
    return kept


def _strokes(along_mm: Sequence[float]) -> int:
    """Count the runs in one direction that are long enough."""
    if not along_mm:
        return 0
    count, direction = 0, 0
    turned = along_mm[0]  # the last turning point, as far as it has got
    for place in along_mm[1:]:
        moved = place - turned
        if direction and moved * direction > 0:
            turned = place  # further along the stroke
        elif abs(moved) >= STROKE_MM:
            count, direction, turned = count + 1, (1 if moved > 0 else -1), place
    return count


def _moves(places: Sequence[Sample], time_s: float) -> bool:
    """Return whether the finger moved along x about a time."""
    after = bisect_left(places, time_s + APART_S / 2, key=lambda each: each.time_s)
    before = bisect_left(places, time_s - APART_S / 2, key=lambda each: each.time_s)
    last, first = min(after, len(places) - 1), max(before - 1, 0)
    passed_s = places[last].time_s - places[first].time_s
    if not 0 < passed_s <= LONGEST_GAP_S:
        return False
    return abs(places[last].values[0] - places[first].values[0]) / passed_s >= MOVES_MM_S
