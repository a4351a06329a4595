"""Represent a plate's calibration, and derive limits and drive voltages from it.

Calibrations are stored in TOML files written by ``slipscale plate calibrate``.
"""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import replace
from datetime import date, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, model_validator

from slipscale.faults import UserError
from slipscale.faults.frozen_table import FrozenTable
from slipscale.faults.message import Message

if TYPE_CHECKING:
    from slipscale.hardware.limits import PlateLimits
    from slipscale.hardware.records import PlateIdentity

OLD_DAYS = 180  # The operator is notified of older calibrations.
EXPIRED_DAYS = 365  # Older calibrations are rejected.
MISFIT = 0.05  # allowed deviation from the fit, relative to the largest reading
CHECKSUM = "sha256"  # key of the checksum in the file
PEAK_OF = {"V peak": 1.0, "V peak-to-peak": 0.5, "V RMS": math.sqrt(2)}

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
# Neither a laboratory nor a plate with soft ceramics can be outside this range.
Temperature = Annotated[float, Field(ge=-40, le=150)]
VoltageConvention = Literal["V peak", "V peak-to-peak", "V RMS"]


class Device(FrozenTable):
    """Calibrated device: its backend, its answer to ``*IDN?``, and the plate's number.

    A board's serial number also identifies its plate. A generator can drive any plate, so a plate
    driven by a generator is identified only by its number, `plate`.
    """

    backend: str
    plate: str = ""
    manufacturer: str = ""
    model: str = ""
    serial: str = ""
    firmware: str = ""


class Provenance(FrozenTable):
    """Date, person, instrument and conditions of the calibration."""

    date: date
    by: str
    instrument: str
    temperature_c: Temperature | None = None
    point: str = ""
    finger: bool = False


class DriveChain(FrozenTable):
    """Voltage convention and amplifier gain used for the calibration.

    All voltages in the file are voltages at the plate, after the amplifier.
    """

    voltage_convention: VoltageConvention = "V peak"
    amplifier_gain: Positive = 1.0
    # Largest voltage before the amplifier, which reveals whether the gain was changed later.
    source_max_v: Positive | None = None
    # Largest voltage in V peak, which reveals whether the convention was changed later.
    plate_max_v_peak: Positive | None = None

    @property
    def v_peak_per_volt(self) -> float:
        """Factor that converts voltages from the file's convention to V peak."""
        return PEAK_OF[self.voltage_convention]


class Resonance(FrozenTable):
    """Fitted resonance. ``_ci95`` fields are half-widths of 95 % confidence intervals."""

    frequency_hz: Positive
    frequency_ci95_hz: NotNegative
    # With a Q of 5,000, a plate at 30.5 kHz takes 0.4 s to settle; tactile plates have a much lower
    # Q.
    quality_factor: Annotated[float, Field(gt=1, le=5_000)]
    quality_factor_ci95: NotNegative
    residual_um: NotNegative


class Gain(FrozenTable):
    """Fitted line through the origin at resonance, in µm p-p per volt."""

    um_pp_per_v: Positive
    um_pp_per_v_ci95: NotNegative
    residual_um: NotNegative
    voltage_max_v: Positive
    amplitude_max_um_pp: Positive


class Point(FrozenTable):
    """One vibrometer reading."""

    sweep: Literal["coarse", "fine", "voltage"]
    frequency_hz: Positive
    voltage_v: NotNegative
    amplitude_um_pp: NotNegative


class Calibration(FrozenTable):
    """Calibration of one plate: the relation between voltage and amplitude.

    Raises
    ------
    ValidationError
        If values are impossible, or if the readings do not match the resonance and the gain. Edited
        files are rejected even if their checksum was updated.
    """

    device: Device
    made: Provenance
    drive: DriveChain
    resonance: Resonance
    gain: Gain
    points: tuple[Point, ...]

    @model_validator(mode="after")
    def _range_was_measured(self) -> Calibration:
        measured_v = [each.voltage_v for each in self.points if each.sweep == "voltage"]
        if not measured_v or self.gain.voltage_max_v > max(measured_v) * (1 + 1e-9):
            raise ValueError("gain.voltage_max_v is larger than every voltage in 'points'")
        half_width_hz = self.resonance.frequency_hz / (2 * self.resonance.quality_factor)
        for each in self.points:
            apart_hz = abs(each.frequency_hz - self.resonance.frequency_hz)
            if each.sweep == "voltage" and not apart_hz <= half_width_hz / 2:
                raise ValueError(
                    Message(
                        "a reading of the voltage sweep was made at {frequency_hz:g} Hz, "
                        "expected the resonance of {resonance_frequency_hz:g} Hz",
                        frequency_hz=each.frequency_hz,
                        resonance_frequency_hz=self.resonance.frequency_hz,
                    )
                )
        return self

    @model_validator(mode="after")
    def _gain_is_the_one_it_was_made_with(self) -> Calibration:
        source_v = self.drive.source_max_v
        made_with = self.gain.voltage_max_v / source_v if source_v else self.drive.amplifier_gain
        if not math.isclose(made_with, self.drive.amplifier_gain, rel_tol=1e-6):
            raise ValueError(
                Message(
                    "drive.amplifier_gain is {amplifier_gain:g}, but the calibration was made "
                    "with {made_with:g} (gain.voltage_max_v divided by drive.source_max_v)",
                    amplifier_gain=self.drive.amplifier_gain,
                    made_with=made_with,
                )
            )
        return self

    @model_validator(mode="after")
    def _convention_is_the_one_it_was_made_with(self) -> Calibration:
        made_with, states = self.drive.plate_max_v_peak, self.gain.voltage_max_v
        if made_with and not math.isclose(
            made_with, states * self.drive.v_peak_per_volt, rel_tol=1e-6
        ):
            raise ValueError(
                Message(
                    "drive.voltage_convention is {convention}, but the calibration was made with "
                    "{made_with:g} V peak (drive.plate_max_v_peak) at {states:g} V "
                    "(gain.voltage_max_v)",
                    convention=self.drive.voltage_convention,
                    made_with=made_with,
                    states=states,
                )
            )
        return self

    @model_validator(mode="after")
    def _readings_follow_from_the_fit(self) -> Calibration:
        fine = [each for each in self.points if each.sweep == "fine"]
        coarse = [each for each in self.points if each.sweep == "coarse"]
        linear = [each for each in self.points if each.sweep == "voltage"]
        for readings in (fine or coarse, linear):
            misfit = self._misfit(readings)
            # For extremely large numbers, the distance is NaN.
            if misfit > MISFIT or math.isnan(misfit):
                raise ValueError(
                    Message(
                        "the readings of the {sweep} sweep differ by {misfit:.0%} from the "
                        "fitted resonance and gain, expected at most {largest_misfit:.0%}",
                        sweep=readings[0].sweep,
                        misfit=misfit,
                        largest_misfit=MISFIT,
                    )
                )
        return self

    def _misfit(self, readings: list[Point]) -> float:
        """Return the RMS difference between readings and fit, relative to the largest reading."""
        largest_um_pp = max((each.amplitude_um_pp for each in readings), default=0.0)
        if largest_um_pp == 0:
            return math.inf if readings else 0.0
        # Unlike squaring, hypot does not overflow.
        apart = math.hypot(*(each.amplitude_um_pp - self.expected_um_pp(each) for each in readings))
        return apart / math.sqrt(len(readings)) / largest_um_pp

    def expected_um_pp(self, point: Point) -> float:
        """Return the amplitude in µm p-p that the fit predicts at a point's drive settings."""
        resonance = self.resonance
        detuning = (point.frequency_hz - resonance.frequency_hz) / resonance.frequency_hz
        lost = math.hypot(1, 2 * resonance.quality_factor * detuning)
        return self.gain.um_pp_per_v * point.voltage_v / lost

    def characteristics(self) -> dict[str, float]:
        """Return resonance, quality factor and gain, keyed by their names in plate files."""
        return {
            "resonance_hz": self.resonance.frequency_hz,
            "quality_factor": self.resonance.quality_factor,
            "um_pp_per_v_peak": self.um_pp_per_v_peak,
        }

    @property
    def um_pp_per_v_peak(self) -> float:
        """Amplitude at resonance in µm p-p per V peak at the plate."""
        return self.gain.um_pp_per_v / self.drive.v_peak_per_volt

    def voltage_v_peak(self, amplitude_um_pp: float) -> float:
        """Return the drive voltage in V peak at the plate for an amplitude in µm p-p."""
        return amplitude_um_pp / self.um_pp_per_v_peak

    def narrow(self, limits: PlateLimits) -> PlateLimits:
        """Narrow limits to the calibrated range, so that nothing is extrapolated.

        Raises
        ------
        UserError
            If the resonance is outside the allowed frequency band.
        """
        frequency_hz = self.resonance.frequency_hz
        if not limits.frequency_min_hz <= frequency_hz <= limits.frequency_max_hz:
            raise UserError(
                "calibration: the resonance of {frequency_hz:g} Hz is outside the plate's band, "
                "{frequency_min_hz:g} to {frequency_max_hz:g} Hz",
                frequency_hz=frequency_hz,
                frequency_min_hz=limits.frequency_min_hz,
                frequency_max_hz=limits.frequency_max_hz,
            )
        voltage_max_v = self.gain.voltage_max_v * self.drive.v_peak_per_volt
        return replace(
            limits,
            level=min(limits.level, self.gain.amplitude_max_um_pp),
            voltage_v=min(limits.voltage_v, voltage_max_v),
        )

    def mismatches(self, identity: PlateIdentity, *, backend: str) -> tuple[str, ...]:
        """Describe how the connected device differs from the calibrated device."""
        compared = (
            ("backend", self.device.backend, backend),
            ("device", self.device.serial, identity.serial),
        )
        return tuple(
            f"the calibration was made on {what} '{made_on}', but this is '{here}'"
            for what, made_on, here in compared
            if made_on != here
        )

    def check_date(self, today: date) -> None:
        """Raise `UserError` if the calibration is too old or dated in the future."""
        made = self.made.date
        if made > today + timedelta(days=1):  # In another time zone, it may already be tomorrow.
            raise UserError(
                "calibration: its date, {made}, is after today ({today}); set this computer's "
                "clock, or recalibrate",
                made=made,
                today=today,
            )
        if (today - made).days > EXPIRED_DAYS:
            raise UserError(
                "calibration: it is {days} days old, expected at most {expired_days} days; "
                "recalibrate",
                days=(today - made).days,
                expired_days=EXPIRED_DAYS,
            )

    def notes(self, today: date) -> tuple[str, ...]:
        """Return notes for the operator, such as a warning about an old calibration."""
        age_days = (today - self.made.date).days
        if age_days > OLD_DAYS:
            return (
                Message("the calibration is {age_days} days old; recalibrate", age_days=age_days),
            )
        return ()

    def summary(self) -> dict[str, object]:
        """Return the calibration without its points but with a checksum, as JSON data."""
        return {**self.model_dump(mode="json", exclude={"points"}), CHECKSUM: checksum(self)}


def write_calibration(calibration: Calibration, path: Path) -> None:
    """Write a calibration file."""
    path.write_text(to_toml(calibration), encoding="utf-8")


def checksum(calibration: Calibration) -> str:
    """Return the SHA-256 of a calibration's content, which does not depend on the file's layout."""
    content = json.dumps(calibration.model_dump(mode="json", exclude_none=True), sort_keys=True)
    return hashlib.sha256(content.encode("utf-8")).hexdigest()


def to_toml(calibration: Calibration) -> str:
    """Format a calibration as TOML text with a checksum."""
    import tomlkit

    document = tomlkit.document()
    document.add(tomlkit.comment("A plate's calibration: see docs/how-to/calibration.md"))
    document.add(CHECKSUM, checksum(calibration))
    document.add(tomlkit.nl())
    document.update(calibration.model_dump(exclude_none=True))
    return tomlkit.dumps(document)
