"""Read and write plate files, which contain identity, limits, wiring and calibration.

Plate files are TOML files that ``slipscale plate new`` writes, users edit, and ``slipscale plate
sign`` signs. The signature is a checksum: a file that was edited afterwards is rejected until it is
signed again. Limits that are wider than the default limits must be acknowledged by a named person,
and are copied into the journal.
"""

from __future__ import annotations

import hashlib
import json
from datetime import date
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from slipscale.faults import UserError
from slipscale.faults.frozen_table import FrozenTable
from slipscale.faults.message import Message
from slipscale.faults.toml_file import read_toml
from slipscale.hardware.calibration.record import Calibration
from slipscale.hardware.calibration.soundness import BOUNDS, implausible
from slipscale.hardware.calibration.stored import read_calibration
from slipscale.hardware.limits import PlateLimits
from slipscale.stimuli.file_names import FileNames
from slipscale.stimuli.quantity_table import QuantityTable, stated_quantity

FOLDER = "plates"  # folder of plate files that are given by name
SUFFIX = ".toml"
SHIPPED = PlateLimits()
CHECKSUM = "sha256"

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Range = tuple[Positive, Positive]


class Identity(FrozenTable):
    """Name and number of the plate, and serial number of the board or generator.

    If ``serial`` is set, a calibration must contain the same number (``--plate-serial``). If
    ``device_serial`` is set, the device must report this number.
    """

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]*$")]
    serial: str = ""
    device_serial: str = ""


class Geometry(FrozenTable):
    """Plate size in mm and number of ceramics, for documentation only."""

    length_mm: Positive | None = None
    width_mm: Positive | None = None
    columns: Annotated[int, Field(gt=0)] | None = None
    rows: Annotated[int, Field(gt=0)] | None = None


class LimitsTable(FrozenTable):
    """Plate limits (see `PlateLimits`). Voltages are in V peak at the plate."""

    level: Positive = SHIPPED.level
    voltage_v_peak: Positive = SHIPPED.voltage_v
    frequency_min_hz: Positive = SHIPPED.frequency_min_hz
    frequency_max_hz: Positive = SHIPPED.frequency_max_hz
    duty: Annotated[float, Field(gt=0, le=1)] = SHIPPED.duty
    duty_window_s: Positive = SHIPPED.duty_window_s
    on_time_s: Positive = SHIPPED.on_time_s
    tolerance: Positive = SHIPPED.tolerance
    deviation_level: Positive = SHIPPED.deviation_level
    voltage_band: Annotated[float, Field(gt=1, allow_inf_nan=False)] = SHIPPED.voltage_band

    @model_validator(mode="after")
    def _band_is_one(self) -> Self:
        if self.frequency_min_hz >= self.frequency_max_hz:
            raise ValueError("frequency_min_hz must be below frequency_max_hz")
        return self

    def beyond_shipped(self) -> dict[str, float]:
        """Return the limits that are wider than the default limits, by name.

        ``duty_window_s`` is not compared, because the default duty cycle of 1 does not restrict the
        plate.
        """
        shipped = LimitsTable()
        wider = {}
        for name in type(self).model_fields:
            own, usual = getattr(self, name), getattr(shipped, name)
            if name != "duty_window_s" and (own < usual if name in LOWER_BOUNDS else own > usual):
                wider[name] = own
        return wider


# Fields that contain levels. The keys of these fields in the file depend on the quantity.
LEVELS = frozenset({"level", "deviation_level"})
# Entries that new files do not contain.
NOT_WRITTEN = ("geometry", CHECKSUM)
LOWER_BOUNDS = ("frequency_min_hz",)


class Expected(FrozenTable):
    """Bounds within which a calibration of the plate is plausible; None means `BOUNDS`."""

    resonance_hz: Range | None = None
    quality_factor: Range | None = None
    um_pp_per_v_peak: Range | None = None


class Wiring(FrozenTable):
    """Backend and sensors of the plate.

    ``amplifier_gain`` is for generators and sound cards, ``channel`` only for generators.
    ``position`` and ``force`` are the specifications (SPEC) of the finger sensors.
    """

    backend: str
    amplifier_gain: Positive | None = None
    channel: Literal[1, 2] | None = None
    position: str | None = None
    force: str | None = None
    notes: str = ""


class CalibrationPlace(FrozenTable):
    """Name of the calibration file, which is in the same folder as the plate file."""

    file: Annotated[str, Field(min_length=1)]


class Acknowledgement(FrozenTable):
    """Limits wider than the default limits, and the person who takes responsibility for them."""

    by: Annotated[str, Field(min_length=1)]
    date: date
    limits: dict[str, float]
    sha256: str = ""

    def checksum(self) -> str:
        """Return the SHA-256 of name, date and limits; only ``plate sign --by`` writes it."""
        content = json.dumps(self.model_dump(mode="json", exclude={CHECKSUM}), sort_keys=True)
        return hashlib.sha256(content.encode("utf-8")).hexdigest()


class PlateFile(FrozenTable):
    """Content of a plate file."""

    identity: Identity
    wiring: Wiring
    geometry: Geometry = Geometry()
    quantity: QuantityTable = QuantityTable()
    limits: LimitsTable = LimitsTable()
    expected: Expected = Expected()
    calibration: CalibrationPlace | None = None
    acknowledgement: Acknowledgement | None = None
    notes: str = ""

    def plate_limits(self) -> PlateLimits:
        """Return the limits for a driver."""
        table = self.limits.model_dump()
        table["voltage_v"] = table.pop("voltage_v_peak")
        return PlateLimits(quantity=self.quantity.quantity, **table)

    @model_validator(mode="after")
    def _stated(self) -> Self:
        quantity, limits = self.quantity.quantity, self.limits
        left_out = LEVELS - limits.model_fields_set
        if left_out and not quantity.in_um_pp:
            names = " and ".join(sorted(quantity.named(each) for each in left_out))
            raise ValueError(
                Message(
                    "[limits]: expected {names}, because the plate produces {quantity_name}",
                    names=names,
                    quantity_name=quantity.name,
                )
            )
        return self

    def beyond_shipped(self) -> dict[str, float]:
        """Return the limits that are wider than the default limits, keyed by name in the file.

        The default levels apply only to amplitudes in µm. For other quantities, ``level`` is
        always included, and ``deviation_level`` is never included.
        """
        quantity, wider = self.quantity.quantity, self.limits.beyond_shipped()
        if not quantity.in_um_pp:
            wider |= {"level": self.limits.level}
            wider.pop("deviation_level", None)
        return {quantity.named(name): value for name, value in wider.items()}

    def in_file(self) -> dict[str, Any]:
        """Return the content as JSON data, with the keys of the file."""
        table = self.model_dump(mode="json")
        quantity = self.quantity.quantity
        if quantity.of_plate:
            del table["quantity"]  # Older files do not contain it.
        elif quantity.named("level") in table["limits"]:
            del table["limits"][quantity.named("level")]  # The level is the drive voltage.
        return FileNames(quantity, LEVELS, frozenset({"limits"})).to_file(table)

    def unacknowledged(self) -> dict[str, float]:
        """Return the limits that exceed the default limits and have not been acknowledged."""
        known = self.acknowledgement.limits if self.acknowledgement else {}
        return {
            name: each for name, each in self.beyond_shipped().items() if known.get(name) != each
        }

    def acknowledged_by_command(self) -> bool:
        """Return whether the acknowledgement is unchanged since ``plate sign --by`` wrote it."""
        known = self.acknowledgement
        return known is not None and known.sha256 == known.checksum()

    def implausible(self, calibration: Calibration) -> list[str]:
        """Describe the values in a calibration that do not match this plate or are implausible."""
        stated = [
            ("backend", calibration.device.backend, self.wiring.backend),
            ("plate", calibration.device.plate, self.identity.serial),
            ("device", calibration.device.serial, self.identity.device_serial),
        ]
        found = [
            f"the calibration was made on {what} '{made_on}', but the plate file has '{own}'"
            for what, made_on, own in stated
            if own and made_on != own
        ]
        found += implausible(calibration, self.expected.model_dump())
        return found

    def summary(self) -> dict[str, object]:
        """Return the content and the checksum as JSON data."""
        return {**_stated(self.in_file()), CHECKSUM: checksum(self)}


class _Signed(PlateFile):
    sha256: str = ""


def checksum(plate: PlateFile) -> str:
    """Return the SHA-256 of a plate file's content, regardless of its layout."""
    content = json.dumps(plate.in_file(), sort_keys=True)
    return hashlib.sha256(content.encode("utf-8")).hexdigest()


def _names(table: dict[str, object]) -> FileNames:
    return FileNames(stated_quantity(table), LEVELS, frozenset({"limits"}))


def _read_signed(path: Path) -> _Signed:
    return read_toml(path, _Signed, names=_names)


def _without_checksum(signed: _Signed) -> PlateFile:
    return PlateFile(**{name: getattr(signed, name) for name in PlateFile.model_fields})


def _stated(table: dict[str, object]) -> dict[str, object]:
    """Remove the entries that are None from a nested table."""
    return {
        key: _stated(value) if isinstance(value, dict) else value
        for key, value in table.items()
        if value is not None
    }


def path_of(text: str, folder: Path) -> Path:
    """Return the path to a plate file, given as a path or as NAME for ``plates/NAME.toml``."""
    return folder / text if text.endswith(SUFFIX) else folder / FOLDER / f"{text}{SUFFIX}"


def read_plate(path: Path) -> PlateFile:
    """Read a plate file without checking its signature.

    Raises
    ------
    UserError
        If the file cannot be read, or if an entry is missing or impossible.
    """
    return _without_checksum(_read_signed(path))


def open_plate_file(path: Path) -> tuple[PlateFile, Calibration | None]:
    """Read a signed plate file and its calibration.

    Raises
    ------
    UserError
        If the file cannot be read or was changed after it was signed, if limits exceed the default
        limits without an acknowledgement, or if the calibration belongs to another plate.
    """
    signed = _read_signed(path)
    plate = _without_checksum(signed)
    if beyond := plate.unacknowledged():
        raise UserError(
            "{path}: {listed} is beyond the shipped limits; the person responsible must sign: "
            "slipscale plate sign {path} --beyond-shipped-limits --by NAME",
            path=path,
            listed=_listed(beyond),
        )
    if signed.sha256 != checksum(plate):
        raise UserError(
            "{path} was changed after it was signed; check the file, then run slipscale plate "
            "sign {path}",
            path=path,
        )
    if plate.calibration is None:
        return plate, None
    place = path.parent / plate.calibration.file
    calibration = read_calibration(place)
    if faults := plate.implausible(calibration):
        raise UserError(
            "{path}: the calibration '{place}' does not belong to this plate: {faults}",
            path=path,
            place=place,
            faults="; ".join(faults),
        )
    return plate, calibration


def new_plate(identity: Identity, wiring: Wiring, path: Path) -> None:
    """Create and sign a plate file with the default limits. Raises UserError."""
    import tomlkit

    expected = Expected.model_validate(BOUNDS)
    plate = PlateFile(identity=identity, wiring=wiring, expected=expected)
    document = tomlkit.document()
    document.add(
        tomlkit.comment("Plate file; see docs/how-to/calibration.md. After a change, run:")
    )
    document.add(tomlkit.comment(f"slipscale plate sign {path.name}"))
    document.add(CHECKSUM, checksum(plate))
    document.add(tomlkit.nl())
    document.update({key: each for key, each in plate.summary().items() if key not in NOT_WRITTEN})
    document["limits"].add(tomlkit.nl())
    for line in NARROW_EXPECTED:
        document["expected"].add(tomlkit.comment(line))
    document["expected"].add(tomlkit.nl())
    for name, example in EXAMPLES.items():
        document.add(tomlkit.comment(f"[{name}]"))
        for line in example:
            document.add(tomlkit.comment(line))
        document.add(tomlkit.nl())
    _write(path, tomlkit.dumps(document), mode="x")


NARROW_EXPECTED = (
    "Narrow these limits to your plate: mistaking peak for peak to peak halves the gain.",
)
EXAMPLES = {
    "geometry": ("length_mm = 83.0", "width_mm = 49.0", "columns = 7", "rows = 5"),
    "calibration": ('file = "calibration.toml"  # next to this file',),
}


def sign(path: Path, *, beyond_by: str = "", today: date) -> dict[str, float]:
    """Sign a plate file, and acknowledge limits that are wider than the default limits.

    Parameters
    ----------
    path : Path
        Path of the plate file. Comments and layout are not changed.
    beyond_by : str
        Name of the person who acknowledges limits beyond the default limits; "" acknowledges none.
    today : date
        Date of the acknowledgement.

    Returns
    -------
    dict of str to float
        Limits that are wider than the default limits.

    Raises
    ------
    UserError
        If the file cannot be read or written, or if limits beyond the defaults are not
        acknowledged.
    """
    import tomlkit

    plate = read_plate(path)
    beyond = plate.beyond_shipped()
    document = tomlkit.parse(path.read_text(encoding="utf-8-sig"))
    if not beyond:
        document.pop("acknowledgement", None)
    elif beyond_by:
        known = Acknowledgement(by=beyond_by, date=today, limits=beyond)
        document["acknowledgement"] = {
            **known.model_dump(exclude={CHECKSUM}),
            CHECKSUM: known.checksum(),
        }
    elif plate.unacknowledged() or not plate.acknowledged_by_command():
        raise UserError(
            "{path}: {listed} is beyond the shipped limits; expected --beyond-shipped-limits and "
            "--by NAME, the name of the person responsible; an acknowledgement typed into the "
            "file is not accepted",
            path=path,
            listed=_listed(plate.unacknowledged() or beyond),
        )
    content = {key: value for key, value in document.unwrap().items() if key != CHECKSUM}
    signed = PlateFile.model_validate(_names(content).to_code(content))
    if CHECKSUM in document:
        document[CHECKSUM] = checksum(signed)
        text = tomlkit.dumps(document)
    else:  # In TOML, top-level keys must come before the first table.
        text = f'{CHECKSUM} = "{checksum(signed)}"\n{tomlkit.dumps(document)}'
    _write(path, text, mode="w")
    return beyond


def _listed(limits: dict[str, float]) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in limits.items())


def _write(path: Path, text: str, *, mode: Literal["x", "w"]) -> None:
    try:
        with path.open(mode, encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise UserError(
            "{path}: cannot be written: {reason}", path=path, reason=error.strerror
        ) from error
