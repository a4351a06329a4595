"""Define periodic waveforms, and the harmonics that can be added to a sine."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Literal, NamedTuple

HALF = 0.5  # of a period
#: Order of each harmonic, keyed by the first word of its parameters. The highest order is 8,
#: because a plate plays at most 64 amplitudes per period, and each period of a sine requires 8.
HARMONICS = {
    "second": 2,
    "third": 3,
    "fourth": 4,
    "fifth": 5,
    "sixth": 6,
    "seventh": 7,
    "eighth": 8,
}
# Number of phases at which a wave's peak is searched for, and accuracy of the peak's phase.
_LOOKED_AT, _EXACT = 720, 1e-7
Waveform = Literal["sine", "square", "triangle", "sawtooth"]


class Harmonic(NamedTuple):
    """Harmonic of a sine: its order (2 or higher), fraction of the depth, and phase (0 to 1)."""

    order: int
    share: float
    phase: float


class Wave(NamedTuple):
    """Function from phase (0 to 1) to amplitude (-1 to 1).

    ``steps_min`` is the smallest number of steps per period with which the wave can be represented.
    """

    value: Callable[[float], float]
    steps_min: int


WAVES: dict[Waveform, Wave] = {
    "sine": Wave(lambda phase: math.sin(2 * math.pi * phase), 8),
    "square": Wave(lambda phase: 1.0 if phase < HALF else -1.0, 2),
    "triangle": Wave(lambda phase: 1 - 4 * abs(((phase + 0.25) % 1) - 0.5), 8),
    "sawtooth": Wave(lambda phase: 2 * phase - 1, 8),
}


def added(phase: float, harmonics: tuple[Harmonic, ...]) -> float:
    """Return the sum of harmonics at a phase (0 to 1), as a fraction of the depth."""
    return sum(
        each.share * math.sin(2 * math.pi * (each.order * phase + each.phase)) for each in harmonics
    )


@cache
def ends_of(harmonics: tuple[Harmonic, ...]) -> tuple[float, float]:
    """Return the smallest and the largest value of a sine with harmonics."""
    if not harmonics:
        return -1.0, 1.0

    def wave(phase: float) -> float:
        return math.sin(2 * math.pi * phase) + added(phase, harmonics)

    def largest(sign: int) -> float:
        peak = max(range(_LOOKED_AT), key=lambda place: sign * wave(place / _LOOKED_AT))
        low, high = (peak - 1) / _LOOKED_AT, (peak + 1) / _LOOKED_AT
        while high - low > _EXACT:
            third = (high - low) / 3
            if sign * wave(low + third) < sign * wave(high - third):
                low += third
            else:
                high -= third
        return wave((low + high) / 2)

    return largest(-1), largest(1)
