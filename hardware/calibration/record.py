"""A plate's calibration: the record, its file, and the limits that follow from it.

The file is human-readable TOML, written by ``slipscale plate calibrate``. It is validated as a
whole, and all errors are reported together with their positions.
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

if TYPE_CHECKING:
    from slipscale.hardware.limits import PlateLimits
    from slipscale.hardware.records import PlateIdentity

OLD_DAYS = 180  # older ones are noted
EXPIRED_DAYS = 365  # older ones are rejected
MISFIT = 0.05  # fraction of the largest reading: allowed deviation from resonance and gain
CHECKSUM = "sha256"  # the file's key
PEAK_OF = {"V peak": 1.0, "V peak-to-peak": 0.5, "V RMS": math.sqrt(2)}

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
VoltageConvention = Literal["V peak", "V peak-to-peak", "V RMS"]


class Device(FrozenTable):
    """The plate's device: the backend, its answer to ``*IDN?``, and any number of the plate.

    A board and its plate are one unit. Plates behind a generator can be exchanged, and only
    `plate` distinguishes them.
    """

    backend: str
    plate: str = ""
    manufacturer: str = ""
    model: str = ""
    serial: str = ""
    firmware: str = ""


class Provenance(FrozenTable):
    """The date, person, instrument and conditions of the calibration."""

    date: date
    by: str
    instrument: str
    temperature_c: Finite | None = None
    point: str = ""
    finger: bool = False


class DriveChain(FrozenTable):
    """The voltage convention, and what follows the generator.

    All volts in the file are volts at the plate, after the amplifier.
    """

    voltage_convention: VoltageConvention = "V peak"
    amplifier_gain: Positive = 1.0
    # The largest voltage before the amplifier; it reveals a gain that was changed later.
    source_max_v: Positive | None = None

    @property
    def v_peak_per_volt(self) -> float:
        """V peak per volt in the file's convention; both at the plate."""
        return PEAK_OF[self.voltage_convention]


class Resonance(FrozenTable):
    """The fitted resonance; ``_ci95`` are half-widths of 95 % confidence intervals."""

    frequency_hz: Positive
    frequency_ci95_hz: NotNegative
    # With 5,000 at 30.5 kHz, a plate takes 0.4 s to settle; tactile plates are far below.
    quality_factor: Annotated[float, Field(gt=1, le=5_000)]
    quality_factor_ci95: NotNegative
    residual_um: NotNegative


class Gain(FrozenTable):
    """The fitted line through the origin at resonance: µm p-p per volt."""

    um_pp_per_v: Positive
    um_pp_per_v_ci95: NotNegative
    residual_um: NotNegative
    voltage_max_v: Positive
    amplitude_max_um_pp: Positive


class Point(FrozenTable):
    """One reading of the vibrometer."""

    sweep: Literal["coarse", "fine", "voltage"]
    frequency_hz: Positive
    voltage_v: NotNegative
    amplitude_um_pp: NotNegative


class Calibration(FrozenTable):
    """The relation between volts and micrometres for one plate.

    Raises
    ------
    ValidationError
        If values are impossible, or the readings do not match resonance and gain: a file with
        edited numbers is rejected even if its checksum was updated.
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
            raise ValueError("gain.voltage_max_v is larger than every voltage in points")
        half_width_hz = self.resonance.frequency_hz / (2 * self.resonance.quality_factor)
        for each in self.points:
            apart_hz = abs(each.frequency_hz - self.resonance.frequency_hz)
            if each.sweep == "voltage" and not apart_hz <= half_width_hz / 2:
                raise ValueError(
                    f"a reading of the voltage sweep was made at {each.frequency_hz:g} Hz, "
                    f"expected the resonance of {self.resonance.frequency_hz:g} Hz"
                )
        return self

    @model_validator(mode="after")
    def _gain_is_the_one_it_was_made_with(self) -> Calibration:
        source_v = self.drive.source_max_v
        made_with = self.gain.voltage_max_v / source_v if source_v else self.drive.amplifier_gain
        if not math.isclose(made_with, self.drive.amplifier_gain, rel_tol=1e-6):
            raise ValueError(
                f"drive.amplifier_gain is {self.drive.amplifier_gain:g}, but the calibration "
                f"was made with {made_with:g} (gain.voltage_max_v divided by "
                "drive.source_max_v)"
            )
        return self

    @model_validator(mode="after")
    def _readings_follow_from_the_fit(self) -> Calibration:
        fine = [each for each in self.points if each.sweep == "fine"]
        coarse = [each for each in self.points if each.sweep == "coarse"]
        linear = [each for each in self.points if each.sweep == "voltage"]
        for readings in (fine or coarse, linear):
            misfit = self._misfit(readings)
            # For extremely large numbers, the distance is nan.
            if misfit > MISFIT or math.isnan(misfit):
                raise ValueError(
                    f"the readings of the {readings[0].sweep} sweep differ by {misfit:.0%} "
                    f"from the fitted resonance and gain, expected at most {MISFIT:.0%}"
                )
        return self

    def _misfit(self, readings: list[Point]) -> float:
        """Return the RMS distance between readings and fit, relative to the largest reading."""
        largest_um_pp = max((each.amplitude_um_pp for each in readings), default=0.0)
        if largest_um_pp == 0:
            return math.inf if readings else 0.0
        # hypot does not overflow, unlike squaring.
        apart = math.hypot(*(each.amplitude_um_pp - self.expected_um_pp(each) for each in readings))
        return apart / math.sqrt(len(readings)) / largest_um_pp

    def expected_um_pp(self, point: Point) -> float:
        """Return the amplitude that resonance and gain predict for a reading's drive, µm p-p."""
        resonance = self.resonance
        detuning = (point.frequency_hz - resonance.frequency_hz) / resonance.frequency_hz
        lost = math.hypot(1, 2 * resonance.quality_factor * detuning)
        return self.gain.um_pp_per_v * point.voltage_v / lost

    def characteristics(self) -> dict[str, float]:
        """Return the plate's characteristic values, under their names in a plate file."""
        return {
            "resonance_hz": self.resonance.frequency_hz,
            "quality_factor": self.resonance.quality_factor,
            "um_pp_per_v_peak": self.um_pp_per_v_peak,
        }

    @property
    def um_pp_per_v_peak(self) -> float:
        """Amplitude at resonance per volt peak at the plate."""
        return self.gain.um_pp_per_v / self.drive.v_peak_per_volt

    def voltage_v_peak(self, amplitude_um_pp: float) -> float:
        """Return the drive voltage for an amplitude in µm p-p, V peak at the plate."""
        return amplitude_um_pp / self.um_pp_per_v_peak

    def narrow(self, limits: PlateLimits) -> PlateLimits:
        """Return the limits narrowed to the calibrated range; nothing is extrapolated.

        Raises
        ------
        UserError
            If the resonance is outside the band in which the plate may be driven.
        """
        frequency_hz = self.resonance.frequency_hz
        if not limits.frequency_min_hz <= frequency_hz <= limits.frequency_max_hz:
            raise UserError(
                f"calibration: the resonance of {frequency_hz:g} Hz is outside the plate's band, "
                f"{limits.frequency_min_hz:g} to {limits.frequency_max_hz:g} Hz"
            )
        voltage_max_v = self.gain.voltage_max_v * self.drive.v_peak_per_volt
        return replace(
            limits,
            level=min(limits.level, self.gain.amplitude_max_um_pp),
            voltage_v=min(limits.voltage_v, voltage_max_v),
        )

    def mismatches(self, identity: PlateIdentity, *, backend: str) -> tuple[str, ...]:
        """Return the differences between the calibrated device and the connected one."""
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
        """Raise `UserError` if the calibration is too old, or dated after today."""
        made = self.made.date
        if made > today + timedelta(days=1):  # it may already be tomorrow in another time zone
            raise UserError(
                f"calibration: its date, {made}, is after today ({today}); set this "
                "computer's clock, or recalibrate"
            )
        if (today - made).days > EXPIRED_DAYS:
            raise UserError(
                f"calibration: it is {(today - made).days} days old, expected at most "
                f"{EXPIRED_DAYS} days; recalibrate"
            )

    def notes(self, today: date) -> tuple[str, ...]:
        """Return notes for the operator, for example that the calibration is old."""
        age_days = (today - self.made.date).days
        if age_days > OLD_DAYS:
            return (f"the calibration is {age_days} days old; recalibrate",)
        return ()

    def summary(self) -> dict[str, object]:
        """Return everything except the points, and the checksum of everything, ready for JSON."""
        return {**self.model_dump(mode="json", exclude={"points"}), CHECKSUM: checksum(self)}


def write_calibration(calibration: Calibration, path: Path) -> None:
    """Write a calibration file."""
    path.write_text(to_toml(calibration), encoding="utf-8")


def checksum(calibration: Calibration) -> str:
    """Return the SHA-256 of a calibration's content, independent of the file's layout."""
    content = json.dumps(calibration.model_dump(mode="json", exclude_none=True), sort_keys=True)
    return hashlib.sha256(content.encode("utf-8")).hexdigest()


def to_toml(calibration: Calibration) -> str:
    """Return the file's text with its checksum; reading it gives an equal calibration."""
    import tomlkit  # noqa: PLC0415 - not needed without a calibration

    document = tomlkit.document()
    document.add(tomlkit.comment("A plate's calibration: see docs/how-to/calibration.md"))
    document.add(CHECKSUM, checksum(calibration))
    document.add(tomlkit.nl())
    document.update(calibration.model_dump(exclude_none=True))
    return tomlkit.dumps(document)
