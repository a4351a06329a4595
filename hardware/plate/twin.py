"""Simulate a plate with its drive, temperature and vibrometer.

The behaviour depends on seed, drive and time, but not on the number of queries, so an interrupted
and resumed session reads the same values as an uninterrupted one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import fmean

import numpy as np

from slipscale.hardware.plate.dynamics import (
    NO_FINGER,
    Conditions,
    FingerLoad,
    Resonator,
    conditions,
)
from slipscale.stimuli.modulation import Loop

TEMPERATURE_PERIODS_S = (2_700.0, 1_130.0, 470.0)  # air conditioning, doors, people
WORD = (1 << 64) - 1  # a Philox key has two 64-bit words
SETTLING_TIME_CONSTANTS = 40  # e^-40: earlier states have no effect in double precision
FIRST_READ_PERIODS = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """Temperature of the surroundings, and warm-up of the plate.

    Parameters
    ----------
    temperature_c : float
        Temperature at the start.
    warm_up_k, warm_up_s : float
        Total temperature rise of the plate in kelvin, and its time constant in seconds.
    wander_k : float
        Largest deviation of the slowly drifting room temperature from ``temperature_c``, in kelvin.
    """

    temperature_c: float = 22.0
    warm_up_k: float = 2.0
    warm_up_s: float = 1_200.0
    wander_k: float = 0.5


@dataclass(frozen=True, slots=True)
class Drive:
    """Drive of the plate: a target amplitude or, if ``target_um_pp`` is None, a voltage.

    A target amplitude is multiplied by ``volts_per_um`` to obtain the voltage. If ``volts_per_um``
    is None, the voltage is the one that an ideal control loop would apply. The voltage limit
    applies to target amplitudes, not to ``voltage_v``. If ``frequency_hz`` is None, the drive
    follows the resonance. The loop ``played`` modulates the amplitude around ``target_um_pp``,
    starting at ``since_s``. If ``since_s`` is None, the loop is computed as if it had started at
    time 0.
    """

    frequency_hz: float | None = None
    voltage_v: float = 0.0
    target_um_pp: float | None = None
    volts_per_um: float | None = None
    played: Loop | None = None
    since_s: float | None = None


OFF = Drive()


class Twin:
    """Simulated plate.

    Parameters
    ----------
    seed : int
        Random seed for room temperature and vibrometer noise.
    resonator : Resonator
        Resonance properties of the plate at the reference temperature.
    finger : FingerLoad
        Effect of the finger on the plate.
    surroundings : Surroundings
        Temperature of the surroundings.
    noise_um : float
        Standard deviation of a vibrometer reading in µm.
    voltage_limit_v : float
        Voltage limit of the board's control loop.
    sensor : float
        Ratio of the sensor's reading to the true amplitude; 1 if the sensor works correctly.
    """

    def __init__(
        self,
        *,
        seed: int = 0,
        resonator: Resonator | None = None,
        finger: FingerLoad = NO_FINGER,
        surroundings: Surroundings | None = None,
        noise_um: float = 0.005,
        voltage_limit_v: float = 16.5,
        sensor: float = 1.0,
    ) -> None:
        self.sensor = sensor
        self.resonator = resonator or Resonator()
        self.finger = finger
        self.surroundings = surroundings or Surroundings()
        self.noise_um = noise_um
        self.voltage_limit_v = voltage_limit_v
        self._seed = seed & WORD
        phases = self._random(WORD).uniform(0, 2 * math.pi, len(TEMPERATURE_PERIODS_S))
        self._phases: list[float] = phases.tolist()
        self._envelope_um_pp: complex = 0
        self._began_um_pp: complex = 0  # envelope at the time when the drive was last set
        self._time_s = 0.0
        self.drive = OFF

    def temperature_c(self, now_s: float) -> float:
        """Return the temperature in °C, which depends only on the seed and the time."""
        waves = [
            math.sin(2 * math.pi * now_s / period_s + phase)
            for period_s, phase in zip(TEMPERATURE_PERIODS_S, self._phases, strict=True)
        ]
        warm_up_k = self.surroundings.warm_up_k * -math.expm1(-now_s / self.surroundings.warm_up_s)
        return (
            self.surroundings.temperature_c
            + warm_up_k
            + self.surroundings.wander_k * sum(waves) / len(waves)
        )

    def conditions(self, now_s: float) -> Conditions:
        """Return resonance frequency, Q and gain at a given time."""
        return conditions(
            self.resonator, temperature_c=self.temperature_c(now_s), finger=self.finger
        )

    def set_drive(self, drive: Drive, now_s: float) -> None:
        """Change the drive at ``now_s``."""
        self._began_um_pp = self._advance(now_s)
        self.drive = drive

    def amplitude_um_pp(self, now_s: float) -> float:
        """Return the true amplitude in µm p-p."""
        return abs(self._advance(now_s))

    def measure_um_pp(self, now_s: float) -> float:
        """Return the vibrometer's reading of the amplitude in µm p-p.

        For a played loop, the reading is the mean over the last complete period, which can be
        compared with the command. The first period is ignored, because it starts at the settled
        mean. Before the end of the second period, the reading is the amplitude before the loop.
        """
        noise_um = self._random(round(now_s * 1e6)).normal(0, self.noise_um)
        played = self.drive.played
        true_um_pp = self._mean_um_pp(played, now_s) if played else self.amplitude_um_pp(now_s)
        return round(float(abs(self.sensor * true_um_pp + noise_um)), 6)

    def voltage_v(self, now_s: float) -> float:
        """Return the drive voltage in V peak or, for a played loop, the largest voltage."""
        played = self.drive.played
        target_um_pp = max(played.levels) if played else self.drive.target_um_pp
        return self._applied(self.conditions(now_s), target_um_pp)[1]

    def _advance(self, now_s: float) -> complex:
        """Advance the envelope to ``now_s``, using the conditions at ``now_s`` throughout."""
        now = self.conditions(now_s)
        if self.drive.played:
            self._envelope_um_pp = self._play(now, self.drive.played, now_s)
        else:
            frequency_hz, voltage_v = self._applied(now, self.drive.target_um_pp)
            self._envelope_um_pp = now.step(
                self._envelope_um_pp,
                max(now_s - self._time_s, 0.0),
                voltage_v=voltage_v,
                frequency_hz=frequency_hz,
            )
        self._time_s = now_s
        return self._envelope_um_pp

    def _play(self, now: Conditions, played: Loop, now_s: float) -> complex:
        """Return the envelope while a loop is played.

        Only the last `SETTLING_TIME_CONSTANTS` time constants are computed, because earlier states
        have no effect.
        """
        since_s = self.drive.since_s
        begin_s = now_s - SETTLING_TIME_CONSTANTS * now.time_constant_s
        if since_s is not None:
            begin_s, now_s = max(begin_s - since_s, 0.0), now_s - since_s
        envelope = self._began_um_pp
        edge_s, steps = played.edge_s, range(played.step_at(begin_s), played.step_at(now_s) + 1)
        _, after_v = self._applied(now, played.before_level(steps[0]))
        for step in steps:
            before_v = after_v
            frequency_hz, after_v = self._applied(now, played.level(step))
            at_s = step * played.step_s
            since, until = max(begin_s - at_s, 0.0), min(now_s - at_s, played.step_s)
            if since < edge_s:
                envelope = now.edge(
                    envelope,
                    since,
                    min(until, edge_s),
                    edge_s=edge_s,
                    before_v=before_v,
                    after_v=after_v,
                    frequency_hz=frequency_hz,
                )
            held_s = max(until - max(since, edge_s), 0.0)
            envelope = now.step(envelope, held_s, voltage_v=after_v, frequency_hz=frequency_hz)
        return envelope

    def _mean_um_pp(self, played: Loop, now_s: float) -> float:
        since_s = self.drive.since_s
        if since_s is not None and now_s - since_s < FIRST_READ_PERIODS * played.period_s:
            return abs(self._began_um_pp)
        now = self.conditions(now_s)
        applied = (self._applied(now, each) for each in played.levels)
        return fmean(
            voltage_v * abs(now.response_um_pp_per_v(frequency_hz))
            for frequency_hz, voltage_v in applied
        )

    def _applied(self, now: Conditions, target_um_pp: float | None) -> tuple[float, float]:
        """Return the drive frequency in Hz and the drive voltage in V."""
        drive = self.drive
        frequency_hz = now.resonance_hz if drive.frequency_hz is None else drive.frequency_hz
        if target_um_pp is None:
            return frequency_hz, drive.voltage_v
        volts_per_um = drive.volts_per_um or 1 / abs(now.response_um_pp_per_v(frequency_hz))
        return frequency_hz, min(target_um_pp * volts_per_um, self.voltage_limit_v)

    def _random(self, counter: int) -> np.random.Generator:
        """Return the random generator for a counter value, independent of earlier draws."""
        return np.random.Generator(
            np.random.Philox(key=np.array([self._seed, counter & WORD], dtype=np.uint64))
        )
