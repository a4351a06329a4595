"""Compute movements between two positions with limited speed and acceleration."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """Movement made up of parts with constant acceleration.

    Parameters
    ----------
    begun_s, from_mm, from_mm_s : float
        Time, position and velocity at the start.
    parts : tuple of (float, float)
        Duration in s and acceleration in mm/s² of each part.
    """

    begun_s: float
    from_mm: float
    from_mm_s: float = 0.0
    parts: tuple[tuple[float, float], ...] = ()

    @property
    def ends_s(self) -> float:
        """Time at which the movement ends."""
        return self.begun_s + sum(duration_s for duration_s, _ in self.parts)

    def state(self, time_s: float) -> tuple[float, float]:
        """Return position in mm and velocity in mm/s at a given time."""
        left_s, place, velocity = time_s - self.begun_s, self.from_mm, self.from_mm_s
        for duration_s, acceleration in self.parts:
            within_s = min(max(left_s, 0.0), duration_s)
            place += velocity * within_s + acceleration * within_s**2 / 2
            velocity += acceleration * within_s
            left_s -= duration_s
        return place, 0.0 if time_s >= self.ends_s else velocity


def travelled(
    now_s: float, from_mm: float, to_mm: float, *, speed_mm_s: float, acceleration_mm_s2: float
) -> Motion:
    """Return the movement from rest at one position to rest at another.

    >>> motion = travelled(0, 0, 40, speed_mm_s=100, acceleration_mm_s2=1000)
    >>> round(motion.ends_s, 6), [round(each, 6) for each in motion.state(0.25)]
    (0.5, [20.0, 100.0])
    """
    distance_mm, sign = abs(to_mm - from_mm), math.copysign(1, to_mm - from_mm)
    fastest = min(speed_mm_s, math.sqrt(acceleration_mm_s2 * distance_mm))
    ramp_s = fastest / acceleration_mm_s2
    even_s = distance_mm / fastest - ramp_s if fastest else 0.0
    ramp = sign * acceleration_mm_s2
    return Motion(
        begun_s=now_s, from_mm=from_mm, parts=((ramp_s, ramp), (even_s, 0.0), (ramp_s, -ramp))
    )
