"""Compute how fast the plate's amplitude and the friction can follow commands.

The amplitude of a plate at resonance follows a command as a first-order lag with the time constant
τ = Q/(π f0), so the plate passes modulation up to f0/(2Q) (-3 dB). For Q = 60 and f0 = 30.5 kHz, τ
is 0.63 ms and f0/(2Q) is 254 Hz. The serial line that transmits the commands usually limits
modulation more. Abrupt changes of the drive would cause clicks, so each change takes several time
constants.

Friction changes more slowly than the amplitude, because gas needs milliseconds to enter and leave
the film (`slipscale.stimuli.film.reynolds.time_constant_s`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from slipscale.faults import UserError

# Fraction of a change below which a finger is assumed to feel only the mean friction.
LEAST_FOLLOWED = 0.2
# `reynolds.time_constant_s` for the paper's finger at 2.3 µm peak to peak and 30.5 kHz.
FILM_TIME_CONSTANT_S = 0.006
STEPS_MAX = 64  # per period; more steps would load the serial line without being felt
EDGE_TIME_CONSTANTS = 3  # of the plate
ROUNDING = 1e-9
STEEP_PART = 0.59  # 10-90 % rise time of a half cosine, as a fraction of its duration
LAG_RISE = math.log(9)  # 10-90 % rise time of a first-order lag, in time constants


def along_edge(start: float, end: float, part: float) -> float:
    """Interpolate between two values along a half cosine; ``part`` runs from 0 to 1."""
    share = 0.5 - 0.5 * math.cos(math.pi * part)
    return start + share * (end - start)


class AmplitudeStep(NamedTuple):
    """Command to hold ``level`` (µm peak to peak) from ``time_s`` on."""

    time_s: float
    level: float


class Followed(NamedTuple):
    """Predicted response of a plate and of friction to a commanded change in amplitude.

    ``change`` describes the change in words. ``plate`` and ``friction`` are the fractions of the
    commanded change (``whole``) that the plate and friction reach, and ``remedy`` describes how to
    increase them. ``rise_s`` is the 10-90 % rise time of friction for a single change.
    """

    change: str
    whole: str
    plate: float
    friction: float
    remedy: str
    rise_s: float | None = None

    @property
    def felt(self) -> bool:
        """Whether friction follows the commanded change closely enough to be felt."""
        return self.friction >= LEAST_FOLLOWED


@dataclass(frozen=True, slots=True, kw_only=True)
class Loop:
    """Sequence of commands that is played repeatedly.

    Parameters
    ----------
    levels : tuple of float
        Commanded amplitudes in µm peak to peak (at least two), held for equal times.
    step_s : float
    edge_s : float
        Duration of the half-cosine edge at the beginning of each step.
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
            raise UserError(
                "loop: expected at least two levels, but found {count}", count=len(self.levels)
            )
        for each in (*self.levels, self.mean_level):
            if not (math.isfinite(each) and each >= 0):
                raise UserError(
                    "loop: each level must be 0 or more, but one is {level}", level=each
                )
        if not (math.isfinite(self.step_s) and 0 < self.edge_s <= self.step_s):
            raise UserError(
                "loop: edge_s must be above 0 and at most step_s ({step_s} s), but is {edge_s} s",
                step_s=self.step_s,
                edge_s=self.edge_s,
            )

    @property
    def period_s(self) -> float:
        """Duration of one period."""
        return len(self.levels) * self.step_s

    def step_at(self, time_s: float) -> int:
        """Return the index of the step at a given time, counted continuously over all periods."""
        return math.floor(time_s / self.step_s)

    def level(self, step: int) -> float:
        """Return the commanded amplitude of a step."""
        return self.levels[step % len(self.levels)]

    def before_level(self, step: int) -> float:
        """Return the amplitude from which a step begins (for step 0, the mean level)."""
        return self.level(step - 1) if step else self.mean_level

    def at_level(self, time_s: float) -> float:
        """Return the commanded amplitude at a given time, including edges."""
        step = self.step_at(time_s)
        before = self.before_level(step)
        part = min((time_s - step * self.step_s) / self.edge_s, 1.0)
        return along_edge(before, self.level(step), part)


@dataclass(frozen=True, slots=True, kw_only=True)
class Modulator:
    """Modulation limits set by a plate and its serial line.

    Parameters
    ----------
    resonance_hz : float
        Resonance f0 of the plate.
    quality_factor : float
        Quality factor Q of the plate, preferably with a finger on it. The default is the quality
        factor of the ceramic.
    command_interval_s : float
        Shortest interval between two commands on the serial line.
    shortest_edge_s : float
        Shortest edge (transition between two amplitudes) that the drive supports.
    film_time_constant_s : float
        Time constant of the film under the finger (time to reach 63 % of a step).
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
                raise UserError(
                    "modulator: {name} must be a positive number, but is {value}",
                    name=name,
                    value=value,
                )

    @property
    def time_constant_s(self) -> float:
        """Time constant of the plate (time in which the amplitude reaches 63 % of a step)."""
        return self.quality_factor / (math.pi * self.resonance_hz)

    @property
    def edge_s(self) -> float:
        """Duration of an edge. A shorter edge would be too fast for the plate and cause a click."""
        return max(EDGE_TIME_CONSTANTS * self.time_constant_s, self.shortest_edge_s)

    @property
    def shortest_step_s(self) -> float:
        """Shortest duration of one amplitude, including the change to this amplitude."""
        return max(self.command_interval_s, self.edge_s)

    @property
    def bandwidth_hz(self) -> float:
        """Modulation frequency at which the plate reproduces 71 % of the modulation depth."""
        return self.resonance_hz / (2 * self.quality_factor)

    def passed(self, modulation_hz: float) -> float:
        """Return the fraction of a sinusoidal modulation's depth that the plate reproduces."""
        return 1 / math.hypot(1, modulation_hz / self.bandwidth_hz)

    def friction_passed(self, modulation_hz: float) -> float:
        """Return the fraction of a sinusoidal modulation's depth that friction reproduces.

        The squeeze-film model of 2007 is used, in which the finger does not move. For later
        measurements, see docs/explanation/squeeze-film.md.
        """
        film_hz = 1 / (2 * math.pi * self.film_time_constant_s)
        return self.passed(modulation_hz) / math.hypot(1, modulation_hz / film_hz)

    def reached(self, duration_s: float | None) -> float:
        """Return the fraction of a change that the plate completes (1 without a time limit)."""
        return 1.0 if duration_s is None else -math.expm1(-duration_s / self.time_constant_s)

    def friction_reached(self, duration_s: float | None) -> float:
        """Return the fraction of a change that friction completes (1 without a time limit).

        Plate and film are modelled as two first-order lags in series.
        """
        if duration_s is None:
            return 1.0
        film, plate = self.film_time_constant_s, self.time_constant_s
        if math.isclose(film, plate):
            return 1 - (1 + duration_s / film) * math.exp(-duration_s / film)
        left = film * math.exp(-duration_s / film) - plate * math.exp(-duration_s / plate)
        return 1 - left / (film - plate)

    def friction_rise_s(self, transition_s: float) -> float:
        """Return the approximate 10-90 % rise time of friction for a change in amplitude.

        The rise times of the transition, the plate and the film are combined as a root sum of
        squares.
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
        """Raise `UserError` unless the plate and its serial line can follow the loop."""
        for what, value_s, shortest_s in (
            ("step_s", loop.step_s, self.shortest_step_s),
            ("edge_s", loop.edge_s, self.edge_s),
        ):
            if value_s < shortest_s * (1 - ROUNDING):
                raise UserError(
                    "loop: {what} must be at least {shortest_s:.6g}, but is {value_s:.6g}",
                    what=what,
                    shortest_s=shortest_s,
                    value_s=value_s,
                )
        if len(loop.levels) > STEPS_MAX:
            raise UserError(
                "loop: expected at most {steps_max} amplitudes, but found {count}",
                steps_max=STEPS_MAX,
                count=len(loop.levels),
            )


DEFAULT_MODULATOR = Modulator()
