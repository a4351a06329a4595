"""Compute the drive that produces a level, from the calibration or from the SPEC.

A plate in µm requires a calibration. For a plate file in another quantity, the SPEC contains

=============  ====================================================================
``frequency``  sine frequency, Hz
``per_volt``   level per V peak at the plate, measured by the user at that frequency;
               for a plate in volts, defined by the voltage convention
=============  ====================================================================
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from slipscale.faults import UserError
from slipscale.hardware import address as addresses
from slipscale.hardware.errors import OverLimit

if TYPE_CHECKING:
    from slipscale.hardware.calibration.record import Calibration
    from slipscale.hardware.limits import PlateLimits

SETTLING_TIME_CONSTANTS = 7  # After this time, the amplitude is within 0.1 % of its final value.
UNKNOWN_PLATE_SETTLING_S = 0.05  # used without a calibration, when Q is unknown
VOLTS = "V"
# Value of a sine with an amplitude of 1 V peak, in each convention.
PER_V_PEAK = {"peak": 1.0, "peak to peak": 2.0, "RMS": math.sqrt(0.5)}
OPTIONS: dict[str, Callable[[str], object]] = {
    "frequency": addresses.positive_number,
    "per_volt": addresses.positive_number,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveOfLevel:
    """Relation between the drive voltage at one frequency and the plate's level."""

    frequency_hz: float
    level_per_v: float
    settling_s: float

    def voltage_v_peak(self, level: float) -> float:
        """Return the drive voltage for a level, in V peak at the plate."""
        return level / self.level_per_v


def calibrated(calibration: Calibration | None) -> DriveOfLevel | None:
    """Return the drive at the calibrated resonance, or None without a calibration."""
    if calibration is None:
        return None
    resonance = calibration.resonance
    time_constant_s = resonance.quality_factor / (math.pi * resonance.frequency_hz)
    return DriveOfLevel(
        frequency_hz=resonance.frequency_hz,
        level_per_v=calibration.um_pp_per_v_peak,
        settling_s=SETTLING_TIME_CONSTANTS * time_constant_s,
    )


def stated(backend: str, options: Mapping[str, Any], plate: addresses.Plate) -> DriveOfLevel | None:
    """Return the drive defined in a SPEC, or None if the SPEC does not define one.

    Raises
    ------
    UserError
        If the plate's quantity is in µm, if the plate has a calibration, if the quantity requires
        other options, or if the frequency is outside the limits.
    """
    if not OPTIONS.keys() & options.keys():
        return None
    quantity = plate.limits.quantity
    if plate.calibration is not None or quantity.in_um_pp:
        raise UserError(
            "plate '{backend}': frequency and per_volt apply only to plate files in a quantity "
            "other than µm; for plates in µm, the calibration contains both values",
            backend=backend,
        )
    in_volts = quantity.unit == VOLTS
    if "frequency" not in options or ("per_volt" in options) == in_volts:
        expected = "frequency=HZ" if in_volts else "frequency=HZ,per_volt=LEVEL"
        raise UserError(
            "plate '{backend}': a plate file in {unit_in_full} requires {expected}",
            backend=backend,
            unit_in_full=quantity.unit_in_full,
            expected=expected,
        )
    try:
        plate.limits.check_frequency(options["frequency"])
    except OverLimit as error:
        raise UserError("plate '{backend}': {error}", backend=backend, error=error) from None
    return DriveOfLevel(
        frequency_hz=options["frequency"],
        level_per_v=PER_V_PEAK[quantity.convention] if in_volts else options["per_volt"],
        settling_s=UNKNOWN_PLATE_SETTLING_S,
    )


def largest_v_peak(limits: PlateLimits) -> float:
    """Return the largest permitted drive voltage in V peak."""
    if limits.quantity.unit == VOLTS:
        return limits.level / PER_V_PEAK[limits.quantity.convention]
    return limits.voltage_v
