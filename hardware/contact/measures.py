"""Measures of an exploration from its samples: speed, number of strokes, friction (pure functions).

Speed and strokes are computed from positions about 50 ms apart; between neighbouring samples,
sensor noise would be mistaken for movement.
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
LONGEST_GAP_S = 0.5  # a longer gap means that the finger was lifted
STROKE_MM = 5.0  # shortest stroke; shorter movements are tremor
MOVES_MM_S = 10.0  # a slower finger may stick
PRESSES_N = 0.05  # with less force, the finger may be off the plate
SLIP_SHARE = 0.1
FEWEST = 10  # minimum number of sliding samples for a coefficient


@dataclass(frozen=True, slots=True, kw_only=True)
class Movement:
    """A finger's movement.

    Parameters
    ----------
    speed_mm_s : float or None
        Path length divided by contact time; None if there are fewer than two samples.
    strokes : int
        Number of movements of 5 mm or more in one direction along x.
    forward_share : float or None
        Proportion of the path along x that leads to larger x; None without movement along x.
    """

    speed_mm_s: float | None
    strokes: int
    forward_share: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Friction:
    """Forces measured while the finger slid.

    Parameters
    ----------
    coefficient : float or None
        Median of the absolute lateral force divided by the normal force.
    normal_n : float or None
        Mean normal force.
    slip_rate_hz : float or None
        Number of slips per second; see `slips`.
    slip_depth_share : float or None
        Median drop in friction during a slip, as a fraction of the value before it; None without a
        slip.
    """

    coefficient: float | None
    normal_n: float | None
    slip_rate_hz: float | None = None
    slip_depth_share: float | None = None


def movement(samples: Sequence[Sample]) -> Movement:
    """Return a finger's movement from samples of x and y in mm."""
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
    """Return the friction while the finger slid.

    Parameters
    ----------
    forces : sequence of Sample
        Normal and lateral force, N.
    places : sequence of Sample
        The finger's positions, if known: only forces during movement along x are used. Otherwise,
        all forces during contact are used.
    """
    pressed = [each for each in forces if each.values[0] >= PRESSES_N]
    slid = [each for each in pressed if _moves(places, each.time_s)] if places else pressed
    if len(slid) < FEWEST:
        return Friction(coefficient=None, normal_n=None)
    ratios = [abs(each.values[1]) / each.values[0] for each in slid]
    slid_s = sum(gap for a, b in pairwise(slid) if (gap := b.time_s - a.time_s) <= LONGEST_GAP_S)
    normal_n = fmean(each.values[0] for each in slid)
    # Without the touch-down and the lift-off, where small forces make ratios unreliable.
    firm = (each.values[0] >= normal_n / 2 for each in slid)
    falls = slips(list(compress(ratios, firm)))
    return Friction(
        coefficient=median(ratios),
        normal_n=normal_n,
        slip_rate_hz=len(falls) / slid_s if slid_s > 0 else None,
        slip_depth_share=median(falls) if falls else None,
    )


def slips(ratios: Sequence[float]) -> list[float]:
    """Return the slips in a series of friction ratios, as fractions of the value before each.

    In stick-slip motion, friction rises while the skin sticks and falls when it slips (Derler and
    Rotaru 2013, Wear 301, 324-329). A slip is a fall by more than `SLIP_SHARE` from a maximum to
    the next minimum; a minimum is over when the ratio has risen by the same share. This definition
    is ours.

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
    """Return the first sample, and each that is 50 ms or more after the previous one returned."""
    kept: list[Sample] = []
    for each in samples:
        if not kept or each.time_s - kept[-1].time_s >= APART_S - 1e-9:
            kept.append(each)
    return kept


def _strokes(along_mm: Sequence[float]) -> int:
    """Count the sufficiently long movements in one direction."""
    if not along_mm:
        return 0
    count, direction = 0, 0
    turned = along_mm[0]  # the extreme position of the current stroke
    for place in along_mm[1:]:
        moved = place - turned
        if direction and moved * direction > 0:
            turned = place  # further along the stroke
        elif abs(moved) >= STROKE_MM:
            count, direction, turned = count + 1, (1 if moved > 0 else -1), place
    return count


def _moves(places: Sequence[Sample], time_s: float) -> bool:
    """Return whether the finger moved along x around a time."""
    after = bisect_left(places, time_s + APART_S / 2, key=lambda each: each.time_s)
    before = bisect_left(places, time_s - APART_S / 2, key=lambda each: each.time_s)
    last, first = min(after, len(places) - 1), max(before - 1, 0)
    passed_s = places[last].time_s - places[first].time_s
    if not 0 < passed_s <= LONGEST_GAP_S:
        return False
    return abs(places[last].values[0] - places[first].values[0]) / passed_s >= MOVES_MM_S
