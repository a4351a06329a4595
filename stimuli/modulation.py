"""How fast a plate can follow: amplitude steps, and the bandwidth that resonance allows.

A plate at resonance rings: its amplitude follows a command as a first-order lag with the time
constant τ = Q/(π f0), so it passes modulation up to f0/(2Q) (-3 dB). With Q = 60 at 30.5 kHz that
is 0.63 ms and 254 Hz; the line that carries the commands is usually slower.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from faults import UserError


class AmplitudeStep(NamedTuple):
    """From ``time_s`` on (0 is the start), hold ``amplitude_um_pp`` (µm peak to peak)."""

    time_s: float
    amplitude_um_pp: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Loop:
    """One period of commands, played over and over.

    Parameters
    ----------
    amplitudes_um_pp : tuple of float
        Amplitudes commanded, µm peak to peak, each for the same time.
    step_s : float
        That time.
    mean_um_pp : float
        Where the plate settles before it plays.
    """

    amplitudes_um_pp: tuple[float, ...]
    step_s: float
    mean_um_pp: float

    def step_at(self, time_s: float) -> int:
        """Return the number of the step at a time, counted from time 0 through all periods."""
        return math.floor(time_s / self.step_s)

    def amplitude_um_pp(self, step: int) -> float:
        """Return the amplitude commanded in a step."""
        return self.amplitudes_um_pp[step % len(self.amplitudes_um_pp)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Modulator:
    """A plate and its line, as far as modulation goes.

    Parameters
    ----------
    resonance_hz : float
        Resonance f0 of the plate.
    quality_factor : float
        Q of the plate, better measured with a finger on it; the default is the ceramic's.
    command_interval_s : float
        Shortest time between two commands on the line.
    """

    resonance_hz: float = 30_500.0
    quality_factor: float = 60.0
    command_interval_s: float = 0.004

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
    def bandwidth_hz(self) -> float:
        """Modulation frequency at which the plate renders 71 % of the depth."""
        return self.resonance_hz / (2 * self.quality_factor)

    def passed(self, modulation_hz: float) -> float:
        """Return the share of a sinusoidal modulation's depth that the plate renders."""
        return 1 / math.hypot(1, modulation_hz / self.bandwidth_hz)

    def fastest_hz(self, steps_per_period: int) -> float:
        """Return the fastest modulation that plate and line allow with so many steps a period."""
        return min(self.bandwidth_hz, 1 / (steps_per_period * self.command_interval_s))


DEFAULT_MODULATOR = Modulator()
