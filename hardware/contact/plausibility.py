"""Check whether the samples of an exploration could come from a finger.

Each rule describes a pattern that a finger cannot produce. If a rule is violated, the trial is
flagged, but its samples are kept.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from statistics import median

from slipscale.hardware.contact.measures import apart
from slipscale.hardware.contact.source import Sample

FEWEST = 20  # minimum number of samples for a check
LONGEST_MM = 300.0  # larger than any plate, but smaller than raw 16-bit values such as 65535
FASTEST_MM_S = 1_500.0  # faster than any finger
FROZEN_S = 1.0  # A working sensor's readings change within this time, because of noise.
EVEN = 0.01  # The distances between a finger's samples vary by more than this fraction.
LARGEST_N = 30.0
NEGATIVE_N = -0.2  # lowest normal force; below it, a load cell is under tension
LARGEST_COEFFICIENT = 3.0  # largest coefficient of friction


def implausible_places(samples: Sequence[Sample]) -> list[str]:
    """Return a message for each way in which positions (in mm) are implausible."""
    return _found(samples, (_too_far, _too_fast, _frozen, _counts))


def implausible_forces(samples: Sequence[Sample]) -> list[str]:
    """Return a message for each way in which normal and lateral forces (in N) are implausible."""
    return _found(samples, (_too_strong, _swapped, _frozen))


def _found(
    samples: Sequence[Sample], rules: Sequence[Callable[[Sequence[Sample]], Iterator[str]]]
) -> list[str]:
    if len(samples) < FEWEST:
        return []
    return [fault for rule in rules for fault in rule(samples)]


def _too_far(samples: Sequence[Sample]) -> Iterator[str]:
    largest = max(abs(value) for each in samples for value in each.values)
    if largest > LONGEST_MM:
        yield f"a position of {largest:g} mm, which is larger than any plate"


def _too_fast(samples: Sequence[Sample]) -> Iterator[str]:
    speeds = [
        math.dist(before.values, after.values) / (after.time_s - before.time_s)
        for before, after in pairwise(apart(samples))  # ignores the sensor's noise
    ]
    if speeds and median(speeds) > FASTEST_MM_S:
        yield f"a median speed of {median(speeds):.0f} mm/s"


def _frozen(samples: Sequence[Sample]) -> Iterator[str]:
    passed_s = samples[-1].time_s - samples[0].time_s
    if passed_s >= FROZEN_S and len({each.values for each in samples}) == 1:
        yield f"the same reading for {passed_s:.1f} s"


def _counts(samples: Sequence[Sample]) -> Iterator[str]:
    """Yield a message if x increases in equal steps, like a time stamp or a counter."""
    steps = [after.values[0] - before.values[0] for before, after in pairwise(samples)]
    mean = sum(steps) / len(steps)
    if mean > 0 and all(abs(step - mean) <= EVEN * mean for step in steps):
        yield "x increases in equal steps, like a time stamp or a counter"


def _too_strong(samples: Sequence[Sample]) -> Iterator[str]:
    normal = [each.values[0] for each in samples]
    largest = max(abs(value) for each in samples for value in each.values)
    if largest > LARGEST_N:
        yield f"a force of {largest:g} N"
    if median(normal) < NEGATIVE_N:
        yield f"a normal force of {median(normal):.2f} N: check its sign and its tare"


def _swapped(samples: Sequence[Sample]) -> Iterator[str]:
    pressed = [each for each in samples if max(map(abs, each.values)) > 0.1]  # noqa: PLR2004 - N
    if len(pressed) < FEWEST:
        return
    ratio = median(abs(each.values[1]) / max(abs(each.values[0]), 1e-3) for each in pressed)
    if ratio > LARGEST_COEFFICIENT:
        yield (
            f"a coefficient of friction of {ratio:.1f}: the normal and lateral forces appear to "
            "be swapped"
        )
