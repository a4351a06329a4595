"""Model the plate in time: ring-up, ring-down, detuning, temperature and a finger.

Near a resonance, the plate behaves as a second-order resonator. A drive close to the resonance
causes a vibration A(t)·cos(2πft) with a complex envelope A that obeys

    dA/dt = -(1/τ + j 2π Δf) (A - A_ss),   τ = Q / (π f0),   Δf = f - f0,
    A_ss = g V / (1 + 2j Q Δf / f0).

For constant drive and resonance, the solution has a closed form, so steps of any length have no
integration error. Within a few bandwidths of the resonance, the envelope agrees with the full
second-order equation to better than 0.5 % (tests/hardware/plate/test_dynamics.py).
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

from slipscale.faults import UserError


@dataclass(frozen=True, slots=True, kw_only=True)
class Resonator:
    """One resonance of a plate.

    Parameters
    ----------
    resonance_hz : float
        Resonance at the reference temperature, without a finger; 30.5 kHz for the paper's plate
        (Fig. 13).
    gain_um_pp_per_v : float
        Amplitude per volt peak at resonance, without a finger; 2.3 µm p-p at 15 V in the paper
        (Section IV-A). The paper does not specify whether 15 V is peak or peak to peak; finite
        elements match the measured amplitude if it is peak.
    quality_factor : float
        Q of the assembled plate, which was not published. The default of 60 is the Q of the ceramic
        and should be replaced by a calibrated value.
    temperature_coefficient_hz_per_k : float
        Change in resonance per kelvin. No value was published; the default is 30.5 kHz times half
        the temperature coefficient of the elastic modulus of copper beryllium (about -350 ppm/K).
    reference_temperature_c : float
        Temperature to which `resonance_hz` refers.
    """

    resonance_hz: float = 30_500.0
    gain_um_pp_per_v: float = 2.3 / 15
    quality_factor: float = 60.0
    temperature_coefficient_hz_per_k: float = -5.3
    reference_temperature_c: float = 22.0

    def __post_init__(self) -> None:
        for name in ("resonance_hz", "gain_um_pp_per_v", "quality_factor"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise UserError(
                    "resonator: {name} is {value}, expected a positive number",
                    name=name,
                    value=value,
                )
        for name in ("temperature_coefficient_hz_per_k", "reference_temperature_c"):
            if not math.isfinite(getattr(self, name)):
                raise UserError("resonator: {name} is not finite", name=name)

    def resonance_at_hz(self, temperature_c: float) -> float:
        """Return the resonance in Hz at a temperature in °C."""
        warmer_k = temperature_c - self.reference_temperature_c
        return self.resonance_hz + self.temperature_coefficient_hz_per_k * warmer_k


@dataclass(frozen=True, slots=True, kw_only=True)
class FingerLoad:
    """Effect of a fingertip on the plate.

    Parameters
    ----------
    loss : float
        Loss added to 1/Q. For example, 1/300 reduces Q from 60 to 50.
    detuning_hz : float
        Shift of the resonance frequency; negative if the finger adds mass to the plate.
    """

    loss: float = 0.0
    detuning_hz: float = 0.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.loss) and self.loss >= 0):
            raise UserError(
                "finger: loss is {loss}, expected a finite number, 0 or more", loss=self.loss
            )
        if not math.isfinite(self.detuning_hz):
            raise UserError("finger: detuning_hz is not finite")


NO_FINGER = FingerLoad()


@dataclass(frozen=True, slots=True, kw_only=True)
class Conditions:
    """Properties of a resonator at a given temperature, with or without a finger.

    Parameters
    ----------
    resonance_hz : float
        Current resonance frequency.
    quality_factor : float
        Quality factor with the finger.
    gain_um_pp_per_v : float
        Gain at resonance, with the finger.
    """

    resonance_hz: float
    quality_factor: float
    gain_um_pp_per_v: float

    @property
    def time_constant_s(self) -> float:
        """Time constant τ, after which 63 % of a change in amplitude is complete."""
        return self.quality_factor / (math.pi * self.resonance_hz)

    def response_um_pp_per_v(self, frequency_hz: float) -> complex:
        """Return the steady-state complex amplitude per volt at a drive frequency."""
        detuning = (frequency_hz - self.resonance_hz) / self.resonance_hz
        return self.gain_um_pp_per_v / (1 + 2j * self.quality_factor * detuning)

    def step(
        self, envelope_um_pp: complex, duration_s: float, *, voltage_v: float, frequency_hz: float
    ) -> complex:
        """Return the envelope after ``duration_s`` of a constant drive.

        Parameters
        ----------
        envelope_um_pp : complex
            Current envelope, in µm peak to peak, with its phase relative to the drive.
        duration_s : float
            Duration of the step; must not be negative.
        voltage_v, frequency_hz : float
            Drive voltage in V peak, and drive frequency.

        Returns
        -------
        complex
            Envelope in µm peak to peak.
        """
        steady = self.response_um_pp_per_v(frequency_hz) * voltage_v
        rate = self._rate_per_s(frequency_hz)
        return steady + (envelope_um_pp - steady) * cmath.exp(-rate * duration_s)

    def edge(
        self,
        envelope_um_pp: complex,
        since_s: float,
        until_s: float,
        *,
        edge_s: float,
        before_v: float,
        after_v: float,
        frequency_hz: float,
    ) -> complex:
        """Return the envelope at ``until_s`` during an edge of the drive.

        The drive changes from one voltage to another along a half cosine of duration ``edge_s``.
        Times are measured from the beginning of the edge. The envelope at ``since_s`` is
        ``envelope_um_pp``.
        """
        rate, turn = self._rate_per_s(frequency_hz), math.pi / edge_s
        response = self.response_um_pp_per_v(frequency_hz)
        middle, half = response * (before_v + after_v) / 2, response * (after_v - before_v) / 2

        def forced(time_s: float) -> complex:
            wave = rate * math.cos(turn * time_s) + turn * math.sin(turn * time_s)
            return middle - half * rate * wave / (rate**2 + turn**2)

        own = envelope_um_pp - forced(since_s)
        return forced(until_s) + own * cmath.exp(-rate * (until_s - since_s))

    def _rate_per_s(self, frequency_hz: float) -> complex:
        return 1 / self.time_constant_s + 2j * math.pi * (frequency_hz - self.resonance_hz)


def conditions(
    resonator: Resonator, *, temperature_c: float | None = None, finger: FingerLoad = NO_FINGER
) -> Conditions:
    """Return the resonator's properties at a temperature, with or without a finger.

    >>> round(conditions(Resonator(), finger=FingerLoad(loss=1 / 300)).quality_factor, 6)
    50.0
    """
    at_c = resonator.reference_temperature_c if temperature_c is None else temperature_c
    quality_factor = 1 / (1 / resonator.quality_factor + finger.loss)
    return Conditions(
        resonance_hz=resonator.resonance_at_hz(at_c) + finger.detuning_hz,
        quality_factor=quality_factor,
        gain_um_pp_per_v=resonator.gain_um_pp_per_v * quality_factor / resonator.quality_factor,
    )
