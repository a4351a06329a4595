"""Compute the commands that make textures follow a measured finger.

A command reaches the plate after a delay and holds until the next command. The amplitude of a
grating or map is therefore computed for the predicted position of the finger, based on its speed in
the last samples. A transient starts at the sample closest to the predicted trigger.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import Protocol

from slipscale.hardware.contact.measures import PRESSES_N
from slipscale.hardware.contact.source import Kind, Sample
from slipscale.hardware.driver import PlateDriver
from slipscale.stimuli.friction_map import FrictionMap
from slipscale.stimuli.modulation import Loop, Modulator
from slipscale.stimuli.surface import Surface
from slipscale.stimuli.texture import Grating
from slipscale.stimuli.transient import Transient

# Time over which the finger's speed is computed. A shorter time makes noise dominate; a longer time
# delays the detection of turns.
SPEED_OVER_S = 0.04
LONGEST_HELD_S = 0.05  # longest interval between frames that predictions allow for
LOST_S = 0.2  # age above which a sample is too old for predictions
LEAST_CHANGE_UM = 0.005  # smallest change that is sent; smaller ones cannot be felt
# Settling time after a change back, before the next change can be played.
SETTLES_S = 0.15
#: Hysteresis: a trigger is reset when the value is lower than the trigger's value by this amount,
#: so that noise does not trigger repeatedly.
BEHIND = {"position_mm": 0.5, "force_n": 0.05, "delay_s": 0.0}


class Follower(Protocol):
    """Common interface for textures that follow the finger."""

    def see(self, samples: Iterable[Sample]) -> None:
        """Process new samples from the sensor."""

    def due(self, now_s: float) -> float | Loop | None:
        """Return the next command: an amplitude, a change to play, or None for no command."""


class Track:
    """Predict x or the normal force, the first quantity of a sensor, from the last samples."""

    def __init__(self) -> None:
        self._last: deque[tuple[float, float]] = deque()
        self._asked_s: float | None = None

    def see(self, samples: Iterable[Sample]) -> None:
        """Add samples."""
        for each in samples:
            self._last.append((each.time_s, each.values[0]))
        while len(self._last) > 2 and self._last[-1][0] - self._last[1][0] >= SPEED_OVER_S:  # noqa: PLR2004 - two samples give a speed
            self._last.popleft()

    def predicted(self, now_s: float, lag_s: float) -> float | None:
        """Predict the value after ``lag_s`` plus half the expected time until the next call.

        Returns None if the last sample is too old.
        """
        asked_s, self._asked_s = self._asked_s, now_s
        held_s = min(now_s - asked_s, LONGEST_HELD_S) if asked_s is not None else 0.0
        if not self._last or now_s - self._last[-1][0] > LOST_S:
            return None
        time_s, value = self._last[-1]
        first_s, first = self._last[0]
        passed_s = time_s - first_s
        speed = (value - first) / passed_s if 0 < passed_s <= LOST_S else 0.0
        return value + speed * (now_s - time_s + lag_s + held_s / 2)


class FollowedTexture:
    """Grating or friction map that follows the finger.

    Parameters
    ----------
    texture : Grating or FrictionMap
    lag_s : float
        Delay between a command and the plate's response.
    """

    def __init__(self, texture: Grating | FrictionMap, lag_s: float) -> None:
        self._texture = texture
        self._lag_s = lag_s
        self._track = Track()
        self._across_mm = 0.0
        self._told_level = texture.settled_level

    def see(self, samples: Iterable[Sample]) -> None:
        """Update the position of the finger."""
        samples = list(samples)
        self._track.see(samples)
        if samples:
            self._across_mm = samples[-1].values[1]

    def level(self, now_s: float) -> float:
        """Return the amplitude at the finger, or the mean if the position is unknown."""
        place_mm = self._track.predicted(now_s, self._lag_s)
        if place_mm is None:
            return self._texture.settled_level
        return self._texture.level_at(place_mm, self._across_mm)

    def due(self, now_s: float) -> float | Loop | None:
        """Return the amplitude to command now, or None if it is nearly unchanged."""
        level = self.level(now_s)
        if abs(level - self._told_level) < LEAST_CHANGE_UM:
            return None
        self._told_level = level
        return level


class FollowedTransient:
    """Transient triggered by the finger: a change of amplitude and its reversal.

    Parameters
    ----------
    transient : Transient
    modulator : Modulator
        How fast and how often the plate's amplitude can be changed.
    """

    def __init__(self, transient: Transient, modulator: Modulator) -> None:
        self._transient = transient
        self._change = transient.change(modulator)
        self._trigger = transient.trigger
        self._at: float = getattr(transient, self._trigger)
        self._behind = BEHIND[self._trigger]
        self._track = Track()
        self._touched_s: float | None = None
        self._holds = False
        self._played_s: float | None = None  # start of the current change
        self._changed = False
        self._ready_s = 0.0

    def see(self, samples: Iterable[Sample]) -> None:
        """Update the position or force from new samples."""
        samples = list(samples)
        self._track.see(samples)
        for each in samples:
            if each.values[0] < PRESSES_N:
                self._touched_s = None
            elif self._touched_s is None:
                self._touched_s = each.time_s

    def due(self, now_s: float) -> float | Loop | None:
        """Return the next command: a change to play, an amplitude, or None for no command."""
        self._holds = self._reached(now_s)
        if self._played_s is not None:
            if now_s - self._played_s < self._transient.active_s:
                return None
            self._played_s = None
            return self._transient.final_level
        if self._changed and not self._holds:
            self._changed, self._ready_s = False, now_s + SETTLES_S
            lasted = self._transient.duration_s is not None
            return None if lasted else self._transient.from_level
        if self._holds and not self._changed and now_s >= self._ready_s:
            self._changed, self._played_s = True, now_s
            return self._change
        return None

    def _reached(self, now_s: float) -> bool:
        value = self._track.predicted(now_s, 0.0)
        if self._trigger == "delay_s":
            value = None if self._touched_s is None else now_s - self._touched_s
        elif value is None:
            return self._holds and self._trigger == "position_mm"  # The finger was lifted.
        if value is None:
            return False
        return value >= self._at - (self._behind if self._holds else 0.0)


def followed_texture(
    surface: Surface, plate: PlateDriver, sensors: frozenset[Kind]
) -> Follower | None:
    """Return an object that makes a texture follow the finger, or None if this is impossible."""
    if surface.sensor not in sensors or plate.follow_lag_s is None:
        return None
    if isinstance(surface, Grating | FrictionMap):
        return FollowedTexture(surface, plate.follow_lag_s)
    if isinstance(surface, Transient) and plate.modulator is not None:
        return FollowedTransient(surface, plate.modulator)
    return None
