"""How fast a plate can follow commands: amplitude steps, and the bandwidth that resonance allows.

A plate at resonance rings: its amplitude follows a command as a first-order lag with the time
constant τ = Q/(π f0), so it passes modulation up to f0/(2Q) (-3 dB). With Q = 60 at 30.5 kHz, that
is 0.63 ms and 254 Hz; the line that transmits the commands is usually slower. A step of the drive
would cause a click, so the drive changes from one amplitude to the next along an edge of several
time constants.

Friction follows more slowly than the amplitude, because gas needs milliseconds to enter and leave
the film (`slipscale.stimuli.film.reynolds.time_constant_s`). Film and plate are two lags in series.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from slipscale.faults import UserError

# Our assumption: if friction keeps less of a change, a finger feels the mean instead.
LEAST_FOLLOWED = 0.2
# Film under the paper's finger at 2.3 µm peak to peak, 30.5 kHz: `reynolds.time_constant_s`.
FILM_TIME_CONSTANT_S = 0.006
STEPS_MAX = 64  # per period: more are not felt, and load the line
EDGE_TIME_CONSTANTS = 3  # of the plate
ROUNDING = 1e-9
STEEP_PART = 0.59  # of a half cosine's duration passes between 10 and 90 % of its change
LAG_RISE = math.log(9)  # time constants of a first-order lag between 10 and 90 %


def along_edge(start: float, end: float, part: float) -> float:
    """Return the value at a fraction (0 to 1) of an edge, a half cosine that avoids a click."""
    share = 0.5 - 0.5 * math.cos(math.pi * part)
    return start + share * (end - start)


class AmplitudeStep(NamedTuple):
    """Hold ``level`` (µm peak to peak) from ``time_s`` on (0 is the start)."""

    time_s: float
    level: float


class Followed(NamedTuple):
    """How well a plate, and friction in the film model, follow a change in amplitude.

    ``change`` describes it, ``plate`` and ``friction`` are the fractions that remain of the
    ``whole``, and ``remedy`` is what makes them larger. ``rise_s`` is the time from 10 to 90 % of a
    single change in friction.
    """

    change: str
    whole: str
    plate: float
    friction: float
    remedy: str
    rise_s: float | None = None

    @property
    def felt(self) -> bool:
        """Whether friction follows well enough."""
        return self.friction >= LEAST_FOLLOWED


@dataclass(frozen=True, slots=True, kw_only=True)
class Loop:
    """One period of commands, played repeatedly.

    Parameters
    ----------
    levels : tuple of float
        Commanded amplitudes, µm peak to peak, each held for the same time; at least two.
    step_s : float
        Duration of each step.
    edge_s : float
        The part of this duration, at its beginning, in which the drive changes from the previous
        amplitude along a half cosine.
    mean_level : float
        Amplitude at which the plate settles before the loop is played.

    Raises
    ------
    UserError
        If an amplitude or a time is out of range.
    """

    levels: tuple[float, ...]
    step_s: float
    edge_s: float
    mean_level: float

    def __post_init__(self) -> None:
        if len(self.levels) < 2:  # noqa: PLR2004 - one amplitude is no modulation
            raise UserError(f"loop: {len(self.levels)} level, expected two or more")
        for each in (*self.levels, self.mean_level):
            if not (math.isfinite(each) and each >= 0):
                raise UserError(f"loop: a level is {each}, expected 0 or more")
        if not (math.isfinite(self.step_s) and 0 < self.edge_s <= self.step_s):
            raise UserError(
                f"loop: step_s is {self.step_s} and edge_s {self.edge_s}, expected an edge above "
                "0 s and no longer than a step"
            )

    @property
    def period_s(self) -> float:
        """Duration of one period."""
        return len(self.levels) * self.step_s

    def step_at(self, time_s: float) -> int:
        """Return the index of the step at a time, counted from time 0 through all periods."""
        return math.floor(time_s / self.step_s)

    def level(self, step: int) -> float:
        """Return the commanded amplitude in a step."""
        return self.levels[step % len(self.levels)]

    def before_level(self, step: int) -> float:
        """Return the amplitude before a step; for step 0 the mean, at which the plate settled."""
        return self.level(step - 1) if step else self.mean_level

    def at_level(self, time_s: float) -> float:
        """Return the amplitude due at a time, including edges."""
        step = self.step_at(time_s)
        before = self.before_level(step)
        part = min((time_s - step * self.step_s) / self.edge_s, 1.0)
        return along_edge(before, self.level(step), part)


@dataclass(frozen=True, slots=True, kw_only=True)
class Modulator:
    """The modulation limits of a plate and its line.

    Parameters
    ----------
    resonance_hz : float
        Resonance f0 of the plate.
    quality_factor : float
        Q of the plate, preferably measured with a finger on it; the default is the ceramic's.
    command_interval_s : float
        Shortest time between two commands on the line.
    shortest_edge_s : float
        Shortest edge between two amplitudes that the drive can shape.
    film_time_constant_s : float
        Time in which the film under the finger covers 63 % of a step.
    """

    resonance_hz: float = 30_500.0
    quality_factor: float = 60.0
    command_interval_s: float = 0.004
    shortest_edge_s: float = 0.002
    film_time_constant_s: float = FILM_TIME_CONSTANT_S

    def __post_init__(self) -> None:
        for name in self.__slots__:
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise UserError(f"modulator: {name} is {value}, expected a positive number")

    @property
    def time_constant_s(self) -> float:
        """Time in which the amplitude covers 63 % of a step."""
        return self.quality_factor / (math.pi * self.resonance_hz)

    @property
    def edge_s(self) -> float:
        """Time from one amplitude to the next; a shorter edge would outrun the plate and click."""
        return max(EDGE_TIME_CONSTANTS * self.time_constant_s, self.shortest_edge_s)

    @property
    def shortest_step_s(self) -> float:
        """Shortest duration of one amplitude, including its edge."""
        return max(self.command_interval_s, self.edge_s)

    @property
    def bandwidth_hz(self) -> float:
        """Modulation frequency at which the plate renders 71 % of the depth."""
        return self.resonance_hz / (2 * self.quality_factor)

    def passed(self, modulation_hz: float) -> float:
        """Return the fraction of a sinusoidal modulation's depth that the plate renders."""
        return 1 / math.hypot(1, modulation_hz / self.bandwidth_hz)

    def friction_passed(self, modulation_hz: float) -> float:
        """Return the fraction of a sinusoidal modulation's depth that the friction follows.

        This follows the 2007 squeeze-film model, in which the finger does not move; for later
        measurements see docs/explanation/squeeze-film.md.
        """
        film_hz = 1 / (2 * math.pi * self.film_time_constant_s)
        return self.passed(modulation_hz) / math.hypot(1, modulation_hz / film_hz)

    def reached(self, duration_s: float | None) -> float:
        """Return the fraction of a change that the plate reaches within its duration, if any."""
        return 1.0 if duration_s is None else -math.expm1(-duration_s / self.time_constant_s)

    def friction_reached(self, duration_s: float | None) -> float:
        """Return the fraction of a change that friction reaches within its duration, if any.

        Plate and film respond one after the other, each as a first-order lag.
        """
        if duration_s is None:
            return 1.0
        film, plate = self.film_time_constant_s, self.time_constant_s
        if math.isclose(film, plate):
            return 1 - (1 + duration_s / film) * math.exp(-duration_s / film)
        left = film * math.exp(-duration_s / film) - plate * math.exp(-duration_s / plate)
        return 1 - left / (film - plate)

    def friction_rise_s(self, transition_s: float) -> float:
        """Return the approximate time in which friction goes from 10 to 90 % of a change.

        It is the root sum of squares of the rise times of the transition, the plate and the film.
        """
        return math.hypot(
            STEEP_PART * transition_s,
            LAG_RISE * self.time_constant_s,
            LAG_RISE * self.film_time_constant_s,
        )

    def fastest_hz(self, steps_per_period: int) -> float:
        """Return the highest modulation frequency for a number of steps per period."""
        return min(self.bandwidth_hz, 1 / (steps_per_period * self.shortest_step_s))

    def check(self, loop: Loop) -> None:
        """Raise `UserError` unless plate and line can follow the loop."""
        for what, value_s, shortest_s in (
            ("step_s", loop.step_s, self.shortest_step_s),
            ("edge_s", loop.edge_s, self.edge_s),
        ):
            if value_s < shortest_s * (1 - ROUNDING):
                raise UserError(f"loop: {what} is {value_s:.6g}, expected {shortest_s:.6g} or more")
        if len(loop.levels) > STEPS_MAX:
            raise UserError(f"loop: {len(loop.levels)} amplitudes, expected at most {STEPS_MAX}")


DEFAULT_MODULATOR = Modulator()
