"""A plate's calibration: the record, its file, and what it allows.

The file is TOML, written by ``slipscale plate calibrate`` and readable by hand. It is validated
whole; what is wrong in it is told at once, with the place.
"""

from __future__ import annotations

import hashlib
import tomllib
from datetime import date
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from faults import UserError
from hardware.limits import PlateLimits

if TYPE_CHECKING:
    from pathlib import Path

    from hardware.records import PlateIdentity

OLD_DAYS = 180

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
VoltageConvention = Literal["V peak", "V peak-to-peak", "V RMS"]


class CalibrationTable(BaseModel):
    """A part of the file: frozen, without unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Device(CalibrationTable):
    """Which plate: what its backend and ``*IDN?`` said."""

    backend: str
    manufacturer: str = ""
    model: str = ""
    serial: str = ""
    firmware: str = ""


class Provenance(CalibrationTable):
    """When, by whom, with what, and under which circumstances."""

    date: date
    by: str
    instrument: str
    temperature_c: Finite | None = None
    point: str = ""
    finger: bool = False


class DriveChain(CalibrationTable):
    """How volts are meant: the convention, and what follows the generator."""

    voltage_convention: VoltageConvention = "V peak"
    amplifier_gain: Positive = 1.0


class Resonance(CalibrationTable):
    """The fitted resonance; ``_ci95`` are half widths of 95 % confidence intervals."""

    frequency_hz: Positive
    frequency_ci95_hz: NotNegative
    quality_factor: Positive
    quality_factor_ci95: NotNegative
    residual_um: NotNegative


class Gain(CalibrationTable):
    """The fitted line through the origin at resonance: µm p-p per volt."""

    um_pp_per_v: Positive
    um_pp_per_v_ci95: NotNegative
    residual_um: NotNegative
    voltage_max_v: Positive
    amplitude_max_um_pp: Positive


class Point(CalibrationTable):
    """One reading of the vibrometer."""

    sweep: Literal["coarse", "fine", "voltage"]
    frequency_hz: Positive
    voltage_v: NotNegative
    amplitude_um_pp: NotNegative


class Calibration(CalibrationTable):
    """What relates volts to micrometres for one plate."""

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
            raise ValueError("gain.voltage_max_v lies beyond the voltages in points")
        return self

    def voltage_v(self, amplitude_um_pp: float) -> float:
        """Return the drive voltage for an amplitude in µm p-p, in the file's convention."""
        return amplitude_um_pp / self.gain.um_pp_per_v

    def narrow(self, limits: PlateLimits) -> PlateLimits:
        """Return the limits, narrowed to what was calibrated: nothing is extrapolated."""
        values = {name: getattr(limits, name) for name in PlateLimits.__slots__}
        values["amplitude_um_pp"] = min(limits.amplitude_um_pp, self.gain.amplitude_max_um_pp)
        values["voltage_v"] = min(limits.voltage_v, self.gain.voltage_max_v)
        return PlateLimits(**values)

    def notes(self, identity: PlateIdentity, today: date) -> tuple[str, ...]:
        """Return what the operator should know: another device, or an old calibration."""
        found = []
        if identity.serial != self.device.serial:
            found.append(
                f"the calibration belongs to plate '{self.device.serial}', "
                f"this is '{identity.serial}'"
            )
        age_days = (today - self.made.date).days
        if age_days > OLD_DAYS:
            found.append(f"the calibration is {age_days} days old; calibrate anew")
        return tuple(found)

    def summary(self) -> dict[str, Any]:
        """Return all but the points, and a hash of everything, ready for JSON."""
        whole = to_toml(self).encode("utf-8")
        return {
            **self.model_dump(mode="json", exclude={"points"}),
            "sha256": hashlib.sha256(whole).hexdigest(),
        }


def read_calibration(path: Path) -> Calibration:
    """Read and validate a calibration file.

    Raises
    ------
    UserError
        There is no such file, it is no TOML, or values are missing or impossible: all are named.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UserError(f"calibration '{path}': {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise UserError(f"calibration '{path}': not a TOML file ({error})") from error
    try:
        return Calibration.model_validate(content)
    except ValidationError as error:
        faults = "; ".join(
            f"{'.'.join(map(str, each['loc'])) or 'file'}: {each['msg']}" for each in error.errors()
        )
        raise UserError(f"calibration '{path}': {faults}") from error


def write_calibration(calibration: Calibration, path: Path) -> None:
    """Write a calibration file."""
    path.write_text(to_toml(calibration), encoding="utf-8")


def to_toml(calibration: Calibration) -> str:
    """Return the file's text; reading it gives an equal calibration."""
    import tomlkit  # noqa: PLC0415 - only who writes a file needs it

    document = tomlkit.document()
    document.add(tomlkit.comment("A plate's calibration: see docs/calibration.md"))
    document.add(tomlkit.nl())
    document.update(calibration.model_dump(exclude_none=True))
    return tomlkit.dumps(document)
