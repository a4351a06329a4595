"""Whether the device that answers is the one that plate file and calibration are for."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import TYPE_CHECKING, ClassVar, Protocol

from slipscale.hardware.errors import WrongDevice

if TYPE_CHECKING:
    from slipscale.hardware.calibration.record import Calibration
    from slipscale.hardware.records import PlateIdentity


class Checked(Protocol):
    """What is asked of a plate's driver."""

    name: ClassVar[str]
    simulated: ClassVar[bool]
    calibration: Calibration | None


def check_device(plate: Checked, identity: PlateIdentity, *, wanted: str) -> tuple[str, ...]:
    """Return what the operator should know of the calibration of a plate that has just answered.

    To a plate that is only simulated, a calibration of another one does no harm: it is noted.

    Parameters
    ----------
    wanted : str
        Serial number of the device that the plate file names; empty if it names none.

    Raises
    ------
    WrongDevice
        Plate file or calibration are of another device, plate or backend.
    UserError
        The calibration is too old, or dated after today.
    """
    if wanted and identity.serial != wanted and not plate.simulated:
        raise WrongDevice(f"the plate file is for device '{wanted}', this is '{identity.serial}'")
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
