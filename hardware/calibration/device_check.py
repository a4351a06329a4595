"""Check that the connected device matches the plate file, the calibration and the session."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import TYPE_CHECKING, ClassVar, Protocol

from slipscale.hardware.errors import WrongDevice

if TYPE_CHECKING:
    from slipscale.hardware.calibration.record import Calibration
    from slipscale.hardware.records import PlateIdentity


class Checked(Protocol):
    """Attributes that the device check requires of a driver."""

    name: ClassVar[str]
    simulated: ClassVar[bool]
    calibration: Calibration | None


def check_device(plate: Checked, identity: PlateIdentity, *, wanted: str) -> tuple[str, ...]:
    """Check a plate's identity; return notes on its calibration for the operator.

    If a simulated plate uses another plate's calibration, a note is returned instead of an error.

    Parameters
    ----------
    wanted : str
        Serial number in the plate file; empty if there is none.

    Raises
    ------
    WrongDevice
        If the plate file or the calibration is for another device, plate or backend.
    UserError
        If the calibration is too old or dated in the future.
    """
    if wanted and identity.serial != wanted and not plate.simulated:
        raise WrongDevice(
            "the plate file is for device '{wanted}', but this is '{serial}'",
            wanted=wanted,
            serial=identity.serial,
        )
    if plate.calibration is None:
        return ()
    today = datetime.now(tz=UTC).date()
    other = plate.calibration.mismatches(identity, backend=plate.name)
    if plate.simulated:
        return (*other, *plate.calibration.notes(today))
    if other:
        raise WrongDevice("; ".join(other))
    plate.calibration.check_date(today)
    return plate.calibration.notes(today)


def check_same_device(before: PlateIdentity | None, now: PlateIdentity) -> None:
    """Raise `WrongDevice` if a device was replaced between two connections of a session."""
    if before is not None and before.serial != now.serial:
        raise WrongDevice(
            "the session began with device '{before}', but this is '{now}'; connect the first one "
            "again, or stop and resume the session with this one",
            before=before.serial,
            now=now.serial,
        )
