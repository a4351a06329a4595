"""Public names for packages that add a backend, which drives a plate.

Import these names from here: their modules may move. See docs/extending/adding-a-backend.md.
"""

from slipscale.faults import UserError
from slipscale.hardware.address import Plate, number, number_from_0, opened, positive_number
from slipscale.hardware.backends.serial_board.serial_line import SerialLine
from slipscale.hardware.clock import Clock, SystemClock, VirtualClock
from slipscale.hardware.driver import PlateDriver
from slipscale.hardware.errors import (
    FAULTS,
    ConnectionLost,
    Frozen,
    GarbledReply,
    Late,
    NoPermission,
    NotReached,
    OffCalibration,
    OverLimit,
    PlateBusy,
    PlateFault,
    PlateNotFound,
    PlateRefused,
    PlateTimeout,
    ProtocolViolation,
    StillVibrating,
    WrongDevice,
)
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.output.unattended import Guarded, StopsAlone, Switch, Unguarded
from slipscale.hardware.records import PlateIdentity, Presentation, Readback
from slipscale.hardware.registry import Backend, open_plate
from slipscale.stimuli.modulation import Loop, Modulator
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity
from slipscale.stimuli.surface import VirtualSurface

__all__ = [
    "FAULTS",
    "PLATE_AMPLITUDE",
    "Backend",
    "Clock",
    "ConnectionLost",
    "Frozen",
    "GarbledReply",
    "Guarded",
    "Late",
    "Loop",
    "Modulator",
    "NoPermission",
    "NotReached",
    "OffCalibration",
    "OverLimit",
    "Plate",
    "PlateBusy",
    "PlateDriver",
    "PlateFault",
    "PlateIdentity",
    "PlateLimits",
    "PlateNotFound",
    "PlateRefused",
    "PlateTimeout",
    "Presentation",
    "ProtocolViolation",
    "Quantity",
    "Readback",
    "SerialLine",
    "StillVibrating",
    "StopsAlone",
    "Switch",
    "SystemClock",
    "Unguarded",
    "UserError",
    "VirtualClock",
    "VirtualSurface",
    "WrongDevice",
    "number",
    "number_from_0",
    "open_plate",
    "opened",
    "positive_number",
]
