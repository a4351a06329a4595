"""Define plate limits, and record how long a plate has vibrated."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

from slipscale.faults import UserError
from slipscale.hardware.errors import NotReached, OffCalibration, OverLimit
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

# Tolerance of an applied amplitude, which is computed from the drive and has no sensor noise.
APPLIED_TOLERANCE = 0.01
ROUNDING = 4e-7  # tolerance for rounded levels, as a fraction of the largest level


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateLimits:
    """Plate limits, which apply to every backend.

    Parameters
    ----------
    quantity : Quantity
        Quantity produced by the plate; it defines the unit of `level` and `deviation_level`.
    level : float
        Largest level. The default, 2.5 µm peak to peak, is slightly above the paper's 2.3 µm at 15
        V (Section IV-A).
    voltage_v : float
        Largest drive voltage in V peak at the plate, after any amplifier (15 V in the paper, "in
        order to avoid dangerous voltages", Section III-B).
    frequency_min_hz, frequency_max_hz : float
        Allowed frequency band.
    duty : float
        Largest duty cycle: the fraction of the last `duty_window_s` seconds with vibration.
    duty_window_s : float
        Duration of the window over which the duty cycle is computed.
    on_time_s : float
        Longest time that the plate vibrates without a new command, in case the session hangs.
    tolerance : float
        Allowed deviation of a *measured* level from the commanded level, as a fraction.
    deviation_level : float
        Allowed deviation, in the unit of the level. The larger of the deviations allowed by
        `tolerance` and `deviation_level` applies.
    voltage_band : float
        Allowed factor between the reported drive voltage and the calibration's prediction, in
        either direction. For example, a finger that reduces Q from 60 to 50 raises the
        required voltage by a factor of 1.2.
    """

    quantity: Quantity = PLATE_AMPLITUDE
    level: float = 2.5
    voltage_v: float = 16.5
    frequency_min_hz: float = 25_000.0
    frequency_max_hz: float = 40_000.0
    duty: float = 1.0
    duty_window_s: float = 600.0
    on_time_s: float = 600.0
    tolerance: float = 0.05
    deviation_level: float = 0.05
    voltage_band: float = 1.5

    def __post_init__(self) -> None:
        for name in self.__slots__[1:]:
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise UserError(
                    "plate limits: {name} is {value}, expected a positive number",
                    name=name,
                    value=value,
                )
        if self.frequency_min_hz >= self.frequency_max_hz:
            raise UserError("plate limits: frequency_min_hz must be below frequency_max_hz")
        if self.duty > 1:
            raise UserError(
                "plate limits: duty is {duty}, expected a duty cycle of at most 1", duty=self.duty
            )
        if self.voltage_band <= 1:
            raise UserError(
                "plate limits: voltage_band is {voltage_band}, expected a factor above 1",
                voltage_band=self.voltage_band,
            )

    def check_level(self, level: float) -> None:
        """Raise `OverLimit` unless the level is finite, not negative and within limits."""
        _check(self.quantity.name, level, 0, self.level, self.quantity.unit_in_short)

    def check_voltage(self, voltage_v: float) -> None:
        """Raise `OverLimit` unless the drive voltage is finite, not negative and within limits."""
        _check("drive voltage", voltage_v, 0, self.voltage_v, "V peak at the plate")

    def check_frequency(self, frequency_hz: float) -> None:
        """Raise `OverLimit` unless the drive frequency is finite and within the band."""
        _check("drive frequency", frequency_hz, self.frequency_min_hz, self.frequency_max_hz, "Hz")

    def allowed_level(self, commanded_level: float) -> float:
        """Return the allowed deviation of a measured level from the commanded level."""
        return max(self.tolerance * commanded_level, self.deviation_level)

    def held_to(self, *, tolerance: float | None, deviation_level: float | None) -> PlateLimits:
        """Return the limits with the given tolerances; a tolerance cannot become wider."""
        return replace(
            self,
            tolerance=min(self.tolerance, tolerance or self.tolerance),
            deviation_level=min(self.deviation_level, deviation_level or self.deviation_level),
        )

    def check_reached(
        self, commanded_level: float, reported_level: float, *, applied: bool = False
    ) -> None:
        """Raise `NotReached` if the reported level differs from the commanded level.

        Parameters
        ----------
        commanded_level, reported_level : float
            Levels in the unit of the plate's quantity.
        applied : bool
            Whether the level was computed from the active drive, so that `APPLIED_TOLERANCE`
            applies.
        """
        q = self.quantity
        allowed, how = self.allowed_level(commanded_level), "measured"
        if applied:
            allowed, how = APPLIED_TOLERANCE * commanded_level + ROUNDING * self.level, "applied"
        if not abs(reported_level - commanded_level) <= allowed:
            raise NotReached(
                "{commanded_level} was commanded, but {reported_level:.3f} {unit_in_short} was "
                "{how} (tolerance {allowed:.3f})",
                commanded_level=q.short(commanded_level),
                reported_level=reported_level,
                unit_in_short=q.unit_in_short,
                how=how,
                allowed=allowed,
            )

    def check_predicted(
        self, commanded_level: float, *, reported_v: float, predicted_v: float
    ) -> None:
        """Raise `OffCalibration` if the drive voltage is outside the allowed band."""
        band = self.voltage_band
        if not predicted_v / band <= reported_v <= predicted_v * band:
            raise OffCalibration(
                "the plate is driven with {reported_v:.2f} V peak at {commanded_level}, but the "
                "calibration predicts {predicted_v:.2f} V (allowed factor {band:g})",
                reported_v=reported_v,
                commanded_level=self.quantity.short(commanded_level),
                predicted_v=predicted_v,
                band=band,
            )


def _check(what: str, value: float, lowest: float, highest: float, unit: str) -> None:
    if not (math.isfinite(value) and lowest <= value <= highest):
        raise OverLimit(
            "{what} {value:g} {unit} is outside {lowest:g} to {highest:g} {unit}",
            what=what,
            value=value,
            unit=unit,
            lowest=lowest,
            highest=highest,
        )


class OnTime:
    """Record of when the plate vibrated, to limit the duty cycle and unattended vibration.

    >>> on_time = OnTime(window_s=100)
    >>> on_time.command(10, vibrates=True)
    >>> on_time.command(40, vibrates=False)
    >>> on_time.duty(60), on_time.duty(120)
    (0.3, 0.2)
    """

    def __init__(self, *, window_s: float) -> None:
        self._window_s = window_s
        # Start and end of past vibrations, as far back as the window for the duty cycle.
        self._spans: deque[tuple[float, float]] = deque()
        self._spans_s = 0.0  # total duration of `_spans`; `duty` must be fast
        self._since: float | None = None
        self._commanded_s = 0.0

    def command(self, now_s: float, *, vibrates: bool) -> None:
        """Record the time of a command, and whether it makes the plate vibrate."""
        if vibrates and self._since is None:
            self._since = now_s
        elif not vibrates and self._since is not None:
            self._spans.append((self._since, now_s))
            self._spans_s += now_s - self._since
            self._since = None
        self._commanded_s = now_s

    def unattended_s(self, now_s: float) -> float:
        """Return how long the plate has vibrated since the last command; 0 if it is off."""
        return 0.0 if self._since is None else now_s - self._commanded_s

    def duty(self, now_s: float) -> float:
        """Return the duty cycle over the last window."""
        start_s = now_s - self._window_s
        while self._spans and self._spans[0][1] <= start_s:
            begun_s, ended_s = self._spans.popleft()
            self._spans_s -= ended_s - begun_s
        if not self._spans:
            self._spans_s = 0.0  # discard accumulated rounding errors
        before_s = max(start_s - self._spans[0][0], 0.0) if self._spans else 0.0
        now_on_s = 0.0 if self._since is None else now_s - max(self._since, start_s)
        # Rounding errors could make the duty cycle slightly larger than 1.
        return min((self._spans_s - before_s + now_on_s) / self._window_s, 1.0)
