"""Control stages that move the plate under a resting finger, or the finger over the plate.

A stage is also a position source: it reports the finger's position on the plate, which textures and
transients follow.

Each command starts one movement of limited length. The next stroke is commanded only when the
program reads samples, so the stage stops at the end of a stroke if the computer fails. Strokes that
exceed the stage's travel or largest speed are rejected before anything moves. If a stage comes to
rest at a wrong position, a fault is raised. Calling `close` stops the stage.

Other packages can add stages as entry points in the group ``slipscale.positions`` that return a
`Stage`. SPEC of the emulated stage: ``emulated_stage`` or ``emulated_stage:option=value,...`` with

================  ================================================================
``travel``        length of the travel between the end stops, mm (100)
``speed``         largest speed, mm/s (300)
``acceleration``  acceleration and deceleration, mm/s² (2000)
``blocked``       place of an obstacle, mm, for tests (none)
``rate``          samples per second (100)
================  ================================================================
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Literal

from slipscale.faults import UserError
from slipscale.hardware import address as addresses
from slipscale.hardware.clock import Clock
from slipscale.hardware.contact.motion import Motion, travelled
from slipscale.hardware.contact.source import (
    POSITION,
    ContactSource,
    Sample,
    SensorFault,
    Surroundings,
    Touch,
)

EMULATED = "emulated_stage"
POLL_S = 0.01  # polling interval while the stage returns to its start
ARRIVED_MM = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Strokes:
    """Strokes between 0 and ``length_mm``, back and forth or once in one direction."""

    speed_mm_s: float
    length_mm: float
    direction: Literal["any", "forward", "backward"] = "any"
    normal_n: float | None = None

    @property
    def start_mm(self) -> float:
        """Position at which the strokes begin."""
        return self.length_mm if self.direction == "backward" else 0.0


class Stage(ContactSource):
    """Base class of stages.

    Parameters
    ----------
    clock : Clock
    travel_mm, fastest_mm_s : float
        Travel, measured from 0, and maximum speed.

    Attributes
    ----------
    presses : bool
        Whether the stage controls the normal force; otherwise, the participant does.
    """

    quantities = POSITION
    presses: ClassVar[bool] = False

    def __init__(self, clock: Clock, *, travel_mm: float, fastest_mm_s: float) -> None:
        self._clock = clock
        self.travel_mm, self.fastest_mm_s = travel_mm, fastest_mm_s
        self._strokes: Strokes | None = None
        self._target_mm = 0.0

    def check(self, strokes: Strokes) -> None:
        """Raise `UserError` if the stage cannot make the strokes."""
        if strokes.length_mm > self.travel_mm:
            raise UserError(
                "stage '{name}': strokes of {length_mm:g} mm exceed its travel of {travel_mm:g} "
                "mm; reduce stroke_mm in [stroke]",
                name=self.name,
                length_mm=strokes.length_mm,
                travel_mm=self.travel_mm,
            )
        if strokes.speed_mm_s > self.fastest_mm_s:
            raise UserError(
                "stage '{name}': {speed_mm_s:g} mm/s exceeds its maximum speed of "
                "{fastest_mm_s:g} mm/s; reduce speed_mm_s in [stroke]",
                name=self.name,
                speed_mm_s=strokes.speed_mm_s,
                fastest_mm_s=self.fastest_mm_s,
            )

    def home(self, strokes: Strokes, watch: Callable[[], None]) -> None:
        """Move to the start of the strokes, calling ``watch`` while waiting."""
        self.check(strokes)
        self._wait(watch)
        if abs(self._place_mm() - strokes.start_mm) > ARRIVED_MM:
            self._command(strokes.start_mm, strokes.speed_mm_s)
            self._wait(watch)
            self._check_arrived()

    def stroke(self, strokes: Strokes) -> None:
        """Begin the strokes."""
        self.check(strokes)
        if self.presses and strokes.normal_n is not None:
            self._press(strokes.normal_n)
        self._strokes = strokes
        self._command(strokes.length_mm - strokes.start_mm, strokes.speed_mm_s)

    def take(self) -> list[Sample]:
        """Return the samples since the last call. If a stroke has ended, command the next one."""
        samples = self._samples()
        if self._strokes and self._rests():
            self._check_arrived()
            if self._strokes.direction == "any":
                turn_mm = self._strokes.length_mm - self._target_mm
                self._command(turn_mm, self._strokes.speed_mm_s)
        return samples

    def stop(self) -> None:
        """Stop the stage as fast as possible; safe to call at any time."""
        self._strokes = None
        self._halt()

    def close(self) -> None:
        """Stop the stage and release the device."""
        self.stop()

    def describe(self) -> dict[str, object]:
        """Return the stage's name, limits and control of the normal force."""
        limits = {"travel_mm": self.travel_mm, "fastest_mm_s": self.fastest_mm_s}
        return {"name": self.name, **limits, "presses": self.presses}

    def _command(self, target_mm: float, speed_mm_s: float) -> None:
        self._target_mm = target_mm
        self._go(target_mm, speed_mm_s)

    def _wait(self, watch: Callable[[], None]) -> None:
        while not self._rests():
            watch()
            self._clock.sleep(POLL_S)

    def _check_arrived(self) -> None:
        if abs((place_mm := self._place_mm()) - self._target_mm) > ARRIVED_MM:
            raise SensorFault(
                "stage '{name}': it stopped at {place_mm:.1f} mm instead of {target_mm:.1f} mm; "
                "something blocks it",
                name=self.name,
                place_mm=place_mm,
                target_mm=self._target_mm,
            )

    @abstractmethod
    def _go(self, target_mm: float, speed_mm_s: float) -> None:
        """Start one movement from rest."""

    @abstractmethod
    def _halt(self) -> None:
        """Start to decelerate; do nothing if the stage is at rest or not connected."""

    @abstractmethod
    def _rests(self) -> bool:
        """Return whether the stage is at rest."""

    @abstractmethod
    def _place_mm(self) -> float:
        """Return the current position."""

    @abstractmethod
    def _samples(self) -> list[Sample]:
        """Return the samples since the last call."""

    def _press(self, normal_n: float) -> None:
        """Set the normal force, if `presses` is True."""
        raise NotImplementedError


class EmulatedStage(Stage):
    """Emulated stage with limited acceleration and end stops.

    For simulated forces, the stage also provides the finger
    (`slipscale.hardware.contact.source.Finger`): its position is that of the stage, and its normal
    force is that of the simulated participant.
    """

    name = EMULATED
    virtual = True
    unit: Literal["mm", "px"] = "mm"

    def __init__(
        self,
        surroundings: Surroundings,
        *,
        travel_mm: float = 100.0,
        fastest_mm_s: float = 300.0,
        acceleration_mm_s2: float = 2000.0,
        blocked_mm: float = math.inf,
        rate_hz: float = 100.0,
    ) -> None:
        super().__init__(surroundings.clock, travel_mm=travel_mm, fastest_mm_s=fastest_mm_s)
        self._finger = surroundings.finger
        self._acceleration_mm_s2 = acceleration_mm_s2
        self._end_mm = min(travel_mm, blocked_mm)
        self._rate_hz = rate_hz
        self._motions = [Motion(begun_s=-math.inf, from_mm=0.0)]
        self._begun_s, self._taken = self._clock.now(), 0

    def connect(self) -> None:
        """Do nothing, because the emulated stage starts at 0."""

    def begin(self) -> None:
        """Start a new series of samples at the current time."""
        self._begun_s, self._taken = self._clock.now(), 0
        self._motions = self._motions[-1:]

    def place_at(self, time_s: float) -> float:
        """Return the position in mm at a given time.

        Movements before the latest `begin` are discarded, except for the last of them.
        """
        motion = next(
            (each for each in reversed(self._motions) if each.begun_s <= time_s), self._motions[0]
        )
        return min(max(motion.state(time_s)[0], 0.0), self._end_mm)

    def at(self, time_s: float) -> Touch | None:
        """Return the finger's state, or None if it does not touch the plate."""
        touch = self._finger.at(time_s) if self._finger else None
        return touch and Touch(self.place_at(time_s), 0.0, touch.normal_n)

    def _go(self, target_mm: float, speed_mm_s: float) -> None:
        now_s = self._clock.now()
        self._motions.append(
            travelled(
                now_s,
                self._place_mm(),
                target_mm,
                speed_mm_s=speed_mm_s,
                acceleration_mm_s2=self._acceleration_mm_s2,
            )
        )

    def _halt(self) -> None:
        if self._rests():
            return
        now_s = self._clock.now()
        place, velocity = self._motions[-1].state(now_s)
        ramp = -math.copysign(self._acceleration_mm_s2, velocity)
        parts = ((abs(velocity) / self._acceleration_mm_s2, ramp),)
        self._motions.append(Motion(begun_s=now_s, from_mm=place, from_mm_s=velocity, parts=parts))

    def _rests(self) -> bool:
        return self._clock.now() >= self._motions[-1].ends_s

    def _place_mm(self) -> float:
        return self.place_at(self._clock.now())

    def _samples(self) -> list[Sample]:
        until = math.floor((self._clock.now() - self._begun_s) * self._rate_hz + 1e-6)
        times = (self._begun_s + n / self._rate_hz for n in range(self._taken, until + 1))
        self._taken = max(until + 1, self._taken)
        return [Sample(each, (self.place_at(each), 0.0)) for each in times]


OPTIONS: dict[str, tuple[str, Callable[[str], object]]] = {
    "travel": ("travel_mm", addresses.positive_number),
    "speed": ("fastest_mm_s", addresses.positive_number),
    "acceleration": ("acceleration_mm_s2", addresses.positive_number),
    "blocked": ("blocked_mm", addresses.positive_number),
    "rate": ("rate_hz", addresses.positive_number),
}


def open_position(address: str, surroundings: Surroundings) -> ContactSource:
    """Return the emulated stage (entry point ``emulated_stage``). Raises `UserError`."""
    known = {name: convert for name, (_, convert) in OPTIONS.items()}
    _, options = addresses.split_address(address, known, what=f"--position {EMULATED}")
    return EmulatedStage(surroundings, **{OPTIONS[name][0]: v for name, v in options.items()})
