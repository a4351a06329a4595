"""The finger of a simulated participant: strokes back and forth with its own speed and force.

=================  ========================  ==================================================
what               value                     source
=================  ========================  ==================================================
speed              log-normal, 60 mm/s, 0.3  our assumption (median, sigma of the logarithm,
                                             between people; 0.1 between explorations)
stroke             40 mm                     our assumption: half of the paper's plate
normal force       log-normal, 0.5 N, 0.3    0.5 N: Biet 2007, Section II-C; the rest is our
                                             assumption (0.1 between explorations)
landing            0.1 s                     our assumption: the force rises evenly from 0
=================  ========================  ==================================================
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

from slipscale.hardware.contact.source import Touch

if TYPE_CHECKING:
    from slipscale.experiments.protocols.ordering.randomisation import Stream

SPEED_MM_S, FORCE_N, STROKE_MM, LANDING_S = 60.0, 0.5, 40.0, 0.1
BETWEEN_PEOPLE, BETWEEN_EXPLORATIONS = 0.3, 0.1


class SimulatedFinger:
    """A finger with a known position at any time of an exploration.

    Parameters
    ----------
    own : Stream
        The participant's random numbers.
    """

    unit: Literal["mm", "px"] = "mm"

    def __init__(self, own: Stream) -> None:
        self._own_speed = SPEED_MM_S * math.exp(BETWEEN_PEOPLE * own.normal())
        self._own_force = FORCE_N * math.exp(BETWEEN_PEOPLE * own.normal())
        self._speed_mm_s = self._own_speed
        self._force_n = self._own_force
        self._begun_s: float | None = None

    def strokes(self, begun_s: float, chance: Stream) -> None:
        """Start stroking, at one end of the stroke."""
        self._begun_s = begun_s
        self._speed_mm_s = self._own_speed * math.exp(BETWEEN_EXPLORATIONS * chance.normal())
        self._force_n = self._own_force * math.exp(BETWEEN_EXPLORATIONS * chance.normal())

    def lifts(self) -> None:
        """Lift the finger off the plate."""
        self._begun_s = None

    def at(self, time_s: float) -> Touch | None:
        """Return position and force; the finger moves sinusoidally at its own mean speed."""
        if self._begun_s is None or time_s < self._begun_s:
            return None
        turns = math.pi * self._speed_mm_s / STROKE_MM * (time_s - self._begun_s)
        pressed = min((time_s - self._begun_s) / LANDING_S, 1.0)
        return Touch(-STROKE_MM / 2 * math.cos(turns), 0.0, pressed * self._force_n)
