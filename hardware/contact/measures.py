"""Compute speed, strokes and friction from the samples of an exploration.

Speed and strokes are computed from positions about 50 ms apart, because sensor noise between
neighbouring samples would look like movement.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress, pairwise
from statistics import fmean, median

from slipscale.hardware.contact.source import Sample

APART_S = 0.05
LONGEST_GAP_S = 0.5  # If the gap between two samples is longer, the finger was lifted.
STROKE_MM = 5.0  # length of the shortest movement that counts as a stroke
MOVES_MM_S = 10.0  # lowest speed of a sliding finger
PRESSES_N = 0.05  # smallest force of a finger on the plate
SLIP_SHARE = 0.1
FEWEST = 10  # minimum number of samples for a coefficient


@dataclass(frozen=True, slots=True, kw_only=True)
class Movement:
    """Finger movement during an exploration.

    Parameters
    ----------
    speed_mm_s : float or None
        Path length divided by contact time; None for fewer than two samples.
    strokes : int
        Number of movements along x of at least 5 mm without a change of direction.
    forward_share : float or None
        Fraction of the path length along x that is in the positive direction; None if the finger
        did not move along x.
    """

    speed_mm_s: float | None
    strokes: int
    forward_share: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Friction:
    """Friction of the sliding finger.

    Parameters
    ----------
    coefficient : float or None
        Median of the absolute lateral force divided by the normal force.
    normal_n : float or None
        Mean normal force.
    slip_rate_hz : float or None
        Number of slips per second; for the definition, see `slips`.
    slip_depth_share : float or None
        Median decrease in friction during a slip, as a fraction of the friction before the slip;
        None without slips.
    """

    coefficient: float | None
    normal_n: float | None
    slip_rate_hz: float | None = None
    slip_depth_share: float | None = None


def movement(samples: Sequence[Sample]) -> Movement:
    """Compute the finger's movement from samples of x and y in mm."""
    kept = apart(samples)
    way_mm = time_s = forward_mm = along_mm = 0.0
    for before, after in pairwise(kept):
        gap_s = after.time_s - before.time_s
        if gap_s <= LONGEST_GAP_S:
            way_mm += math.dist(before.values, after.values)
            time_s += gap_s
            step_mm = after.values[0] - before.values[0]
            along_mm += abs(step_mm)
            forward_mm += max(step_mm, 0.0)
    return Movement(
        speed_mm_s=way_mm / time_s if time_s > 0 else None,
        strokes=_strokes([each.values[0] for each in kept]),
        forward_share=forward_mm / along_mm if along_mm > 0 else None,
    )


def friction(forces: Sequence[Sample], places: Sequence[Sample] = ()) -> Friction:
    """Compute the friction of the sliding finger.

    Parameters
    ----------
    forces : sequence of Sample
        Normal and lateral force, N.
    places : sequence of Sample
        Positions of the finger, if known. If given, only forces during movement along x are used;
        otherwise, all forces during contact.
    """
    pressed = [each for each in forces if each.values[0] >= PRESSES_N]
    slid = [each for each in pressed if _moves(places, each.time_s)] if places else pressed
    if len(slid) < FEWEST:
        return Friction(coefficient=None, normal_n=None)
    ratios = [abs(each.values[1]) / each.values[0] for each in slid]
    slid_s = sum(gap for a, b in pairwise(slid) if (gap := b.time_s - a.time_s) <= LONGEST_GAP_S)
    normal_n = fmean(each.values[0] for each in slid)
    # Touch-down and lift-off are excluded, because ratios of small forces are unreliable.
    firm = (each.values[0] >= normal_n / 2 for each in slid)
    falls = slips(list(compress(ratios, firm)))
    return Friction(
        coefficient=median(ratios),
        normal_n=normal_n,
        slip_rate_hz=len(falls) / slid_s if slid_s > 0 else None,
        slip_depth_share=median(falls) if falls else None,
    )


def slips(ratios: Sequence[float]) -> list[float]:
    """Detect slips in a series of friction ratios, and return the relative decrease in each.

    In stick-slip motion, friction rises while the skin sticks and falls when the skin slips (Derler
    and Rotaru 2013, Wear 301, 324-329). A slip is defined as a decrease by more than `SLIP_SHARE`
    from a maximum to the next minimum. A slip ends when the friction ratio has risen by
    `SLIP_SHARE` from this minimum.

    >>> slips([0.5, 1.0, 0.6, 0.8, 0.78, 0.4, 0.41])
    [0.4, 0.5]
    """
    found: list[float] = []
    high = low = ratios[0] if ratios else 0.0
    falling = False
    for ratio in ratios:
        if falling and ratio > low * (1 + SLIP_SHARE):
            found.append(round(1 - low / high, 6))
            falling, high = False, ratio
        elif falling:
            low = min(low, ratio)
        elif ratio < high * (1 - SLIP_SHARE):
            falling, low = True, ratio
        else:
            high = max(high, ratio)
    return [*found, round(1 - low / high, 6)] if falling else found


def apart(samples: Sequence[Sample]) -> list[Sample]:
    """Return samples that are at least 50 ms apart."""
    kept: list[Sample] = []
    for each in samples:
        if not kept or each.time_s - kept[-1].time_s >= APART_S - 1e-9:
            kept.append(each)
    return kept


def _strokes(along_mm: Sequence[float]) -> int:
    """Count strokes: sufficiently long movements in one direction."""
    if not along_mm:
        return 0
    count, direction = 0, 0
    turned = along_mm[0]  # extreme position of the current stroke
    for place in along_mm[1:]:
        moved = place - turned
        if direction and moved * direction > 0:
            turned = place  # further along the stroke
        elif abs(moved) >= STROKE_MM:
            count, direction, turned = count + 1, (1 if moved > 0 else -1), place
    return count


def _moves(places: Sequence[Sample], time_s: float) -> bool:
    """Return whether the finger moved along x around the given time."""
    after = bisect_left(places, time_s + APART_S / 2, key=lambda each: each.time_s)
    before = bisect_left(places, time_s - APART_S / 2, key=lambda each: each.time_s)
    last, first = min(after, len(places) - 1), max(before - 1, 0)
    passed_s = places[last].time_s - places[first].time_s
    if not 0 < passed_s <= LONGEST_GAP_S:
        return False
    return abs(places[last].values[0] - places[first].values[0]) / passed_s >= MOVES_MM_S
