"""Finger of a simulated participant, with individual speed and force.

=================  ========================  ==================================================
what               value                     source
=================  ========================  ==================================================
speed              log-normal, 60 mm/s, 0.3  our assumption (median, sigma of the logarithm,
                                             between people; 0.1 between explorations)
stroke             40 mm                     our assumption: half of the paper's plate
normal force       log-normal, 0.5 N, 0.3    0.5 N: Biet 2007, Section II-C; the rest is our
                                             assumption (0.1 between explorations)
landing            0.1 s                     our assumption: the force rises evenly from 0
guided stroke      a third of the deviations our assumption; speed and force are then close to
                   between people            the study's
=================  ========================  ==================================================
"""

from __future__ import annotations

import math
from typing import Literal

from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.experiments.steps.steps import Guide
from slipscale.hardware.contact.source import Touch

SPEED_MM_S, FORCE_N, STROKE_MM, LANDING_S = 60.0, 0.5, 40.0, 0.1
BETWEEN_PEOPLE, BETWEEN_EXPLORATIONS = 0.3, 0.1
GUIDED = 1 / 3  # exponent of a person's individual deviation if the stroke is guided
LIFTED_S = 0.6


class SimulatedFinger:
    """Simulated finger, with a position that can be computed for any time of an exploration.

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
        self._guide: Guide | None = None

    def strokes(self, begun_s: float, chance: Stream, guide: Guide | None = None) -> None:
        """Start stroking at one end of the stroke.

        If ``guide`` prescribes a speed or force, the finger's speed or force is close to it.
        """
        self._begun_s = begun_s
        self._guide = guide
        speed_mm_s, force_n = self._own_speed, self._own_force
        if guide and guide.speed_mm_s:
            speed_mm_s = guide.speed_mm_s * (self._own_speed / SPEED_MM_S) ** GUIDED
        if guide and guide.normal_force_n:
            force_n = guide.normal_force_n * (self._own_force / FORCE_N) ** GUIDED
        self._speed_mm_s = speed_mm_s * math.exp(BETWEEN_EXPLORATIONS * chance.normal())
        self._force_n = force_n * math.exp(BETWEEN_EXPLORATIONS * chance.normal())

    def lifts(self) -> None:
        """Lift the finger off the plate."""
        self._begun_s = None

    def at(self, time_s: float) -> Touch | None:
        """Return the position and the force of a finger that moves sinusoidally.

        If the study requires strokes in one direction, the finger moves at a constant speed and is
        lifted for `LIFTED_S` before the next stroke. If a stage moves the plate, the finger stays
        in place.
        """
        if self._begun_s is None or time_s < self._begun_s:
            return None
        passed_s = time_s - self._begun_s
        guide = self._guide
        if guide and guide.passive:
            place = 0.0
        elif guide and guide.direction != "any":
            stroke_s = guide.stroke_mm / self._speed_mm_s
            passed_s %= stroke_s + LIFTED_S
            if passed_s > stroke_s:
                return None
            way = 1 if guide.direction == "forward" else -1
            place = way * (self._speed_mm_s * passed_s - guide.stroke_mm / 2)
        else:
            turns = math.pi * self._speed_mm_s / STROKE_MM * passed_s
            place = -STROKE_MM / 2 * math.cos(turns)
        return Touch(place, 0.0, min(passed_s / LANDING_S, 1.0) * self._force_n)
