"""The physical twin: a simulated plate with its drive, temperature and vibrometer.

What it does depends on its seed, its drive and the time, never on how often it was asked: a
session that was interrupted and resumed reads back what an undisturbed one would have.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hardware.plate.dynamics import NO_FINGER, Conditions, Finger, Resonator, conditions

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stimuli.modulation import Loop

TEMPERATURE_PERIODS_S = (2_700.0, 1_130.0, 470.0)  # air conditioning, doors, people
WORD = (1 << 64) - 1  # a Philox key has two 64-bit words
SETTLING_TIME_CONSTANTS = 40  # e^-40: to the last digit, nothing is left of what was before


@dataclass(frozen=True, slots=True, kw_only=True)
class Room:
    """Where the plate stands.

    Parameters
    ----------
    temperature_c : float
        At the start.
    warm_up_k, warm_up_s : float
        The plate warms by so many kelvin with this time constant.
    wander_k : float
        Largest slow change of the room's temperature around that.
    """

    temperature_c: float = 22.0
    warm_up_k: float = 2.0
    warm_up_s: float = 1_200.0
    wander_k: float = 0.5


@dataclass(frozen=True, slots=True)
class Drive:
    """What drives the plate.

    Either a voltage (``target_um_pp`` is None), or an amplitude that the board's control loop
    holds as long as its voltage suffices; the loop is taken as ideal. ``frequency_hz`` None
    follows the resonance. ``played`` modulates the amplitude, about ``target_um_pp``: where in
    its period it is depends on the time alone.
    """

    frequency_hz: float | None = None
    voltage_v: float = 0.0
    target_um_pp: float | None = None
    played: Loop | None = None


OFF = Drive()


class Twin:
    """A simulated plate.

    Parameters
    ----------
    seed : int
        Of the room's temperature and the vibrometer's noise.
    resonator : Resonator
        The plate's resonance at its reference temperature.
    finger : Finger
        What rests on it.
    room : Room
        Its surroundings.
    noise_um : float
        Standard deviation of a vibrometer reading in µm.
    voltage_limit_v : float
        Largest voltage of the board's control loop.
    """

    def __init__(
        self,
        *,
        seed: int = 0,
        resonator: Resonator | None = None,
        finger: Finger = NO_FINGER,
        room: Room | None = None,
        noise_um: float = 0.005,
        voltage_limit_v: float = 16.5,
    ) -> None:
        self.resonator = resonator or Resonator()
        self.finger = finger
        self.room = room or Room()
        self.noise_um = noise_um
        self.voltage_limit_v = voltage_limit_v
        self._seed = seed & WORD
        phases = self._random(WORD).uniform(0, 2 * math.pi, len(TEMPERATURE_PERIODS_S))
        self._phases: list[float] = phases.tolist()
        self._envelope_um_pp: complex = 0
        self._time_s = 0.0
        self.drive = OFF

    def temperature_c(self, now_s: float) -> float:
        """Return the plate's temperature in °C, a function of seed and time alone."""
        waves = [
            math.sin(2 * math.pi * now_s / period_s + phase)
            for period_s, phase in zip(TEMPERATURE_PERIODS_S, self._phases, strict=True)
        ]
        warm_up_k = self.room.warm_up_k * -math.expm1(-now_s / self.room.warm_up_s)
        return self.room.temperature_c + warm_up_k + self.room.wander_k * sum(waves) / len(waves)

    def conditions(self, now_s: float) -> Conditions:
        """Return resonance, Q and gain at a time."""
        return conditions(
            self.resonator, temperature_c=self.temperature_c(now_s), finger=self.finger
        )

    def set_drive(self, drive: Drive, now_s: float) -> None:
        """Change the drive at ``now_s``."""
        self._advance(now_s)
        self.drive = drive

    def amplitude_um_pp(self, now_s: float) -> float:
        """Return the true amplitude in µm p-p."""
        return abs(self._advance(now_s))

    def measure_um_pp(self, now_s: float) -> float:
        """Return a vibrometer's reading of the amplitude in µm p-p."""
        noise_um = self._random(round(now_s * 1e6)).normal(0, self.noise_um)
        return round(float(abs(self.amplitude_um_pp(now_s) + noise_um)), 6)

    def voltage_v(self, now_s: float) -> float:
        """Return the drive voltage, V peak."""
        target_um_pp = self.drive.target_um_pp
        if played := self.drive.played:
            target_um_pp = played.amplitude_um_pp(played.step_at(now_s))
        return self._applied(self.conditions(now_s), target_um_pp)[1]

    def _advance(self, now_s: float) -> complex:
        """Let the envelope run to ``now_s``; conditions change far slower than it does."""
        now = self.conditions(now_s)
        for duration_s, target_um_pp in self._targets(now, now_s):
            frequency_hz, voltage_v = self._applied(now, target_um_pp)
            self._envelope_um_pp = now.step(
                self._envelope_um_pp, duration_s, voltage_v=voltage_v, frequency_hz=frequency_hz
            )
        self._time_s = now_s
        return self._envelope_um_pp

    def _targets(self, now: Conditions, now_s: float) -> Iterator[tuple[float, float | None]]:
        """Yield what was to be held up to ``now_s``, as (for how many seconds, µm p-p).

        Of what is played only the last time constants are gone through: nothing is left of what
        was before, and so the amplitude depends on the time and not on when one last looked.
        """
        played = self.drive.played
        if played is None:
            yield max(now_s - self._time_s, 0.0), self.drive.target_um_pp
            return
        begin_s = now_s - SETTLING_TIME_CONSTANTS * now.time_constant_s
        for step in range(played.step_at(begin_s), played.step_at(now_s) + 1):
            since_s = max(step * played.step_s, begin_s)
            until_s = min((step + 1) * played.step_s, now_s)
            yield max(until_s - since_s, 0.0), played.amplitude_um_pp(step)

    def _applied(self, now: Conditions, target_um_pp: float | None) -> tuple[float, float]:
        """Return the frequency in Hz and the voltage in V that are on the plate."""
        drive = self.drive
        frequency_hz = now.resonance_hz if drive.frequency_hz is None else drive.frequency_hz
        if target_um_pp is None:
            return frequency_hz, drive.voltage_v
        needed_v = target_um_pp / abs(now.response_um_pp_per_v(frequency_hz))
        return frequency_hz, min(needed_v, self.voltage_limit_v)

    def _random(self, counter: int) -> np.random.Generator:
        """Return the generator of one counter: nothing depends on what was drawn before."""
        return np.random.Generator(
            np.random.Philox(key=np.array([self._seed, counter & WORD], dtype=np.uint64))
        )
