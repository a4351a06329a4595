"""Check that the connected device is the one in the plate file and the calibration."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import TYPE_CHECKING, ClassVar, Protocol

from slipscale.hardware.errors import WrongDevice

if TYPE_CHECKING:
    from slipscale.hardware.calibration.record import Calibration
    from slipscale.hardware.records import PlateIdentity


class Checked(Protocol):
    """The part of a plate's driver that the check uses."""

    name: ClassVar[str]
    simulated: ClassVar[bool]
    calibration: Calibration | None


def check_device(plate: Checked, identity: PlateIdentity, *, wanted: str) -> tuple[str, ...]:
    """Check a plate that has just answered; return notes on its calibration for the operator.

    For a simulated plate, the calibration of another plate is harmless and is only noted.

    Parameters
    ----------
    wanted : str
        Serial number of the device in the plate file; empty if it has none.

    Raises
    ------
    WrongDevice
        If the plate file or the calibration is for another device, plate or backend.
    UserError
        If the calibration is too old, or dated after today.
    """
    if wanted and identity.serial != wanted and not plate.simulated:
        raise WrongDevice(
            f"the plate file is for device '{wanted}', but this is '{identity.serial}'"
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
