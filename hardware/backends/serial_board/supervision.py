"""Check the status of a driver board while it presents a surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from slipscale.faults.message import Message
from slipscale.hardware.errors import (
    ConnectionLost,
    NotReached,
    OverLimit,
    PlateFault,
    PlateRefused,
    PlateTimeout,
)

if TYPE_CHECKING:
    from slipscale.hardware.backends.serial_board.protocol import BoardStatus
    from slipscale.hardware.limits import PlateLimits
    from slipscale.stimuli.quantity import Quantity

# Reasons why a board that should vibrate does not.
SILENCED: dict[str, tuple[type[PlateFault], str]] = {
    "OFF": (ConnectionLost, "the board switched its output off"),
    "WDOG": (
        PlateTimeout,
        ("the board received nothing from this computer and switched the plate off"),
    ),
    "HOT": (PlateRefused, "the board overheated and switched the plate off"),
    "LONG": (OverLimit, "the board switched the plate off because it was on for too long"),
    "OPEN": (PlateRefused, "the board drives the plate in open loop"),
}


# Number of periods within which the board must correct the mean of a list. The board corrects by
# 5 % after each period, so four corrections are enough if Q drops from 60 to 50.
CORRECTED_PERIODS = 6
# State of a plate that follows a finger between ramps; the board does not report this state.
FOLLOWS = "FOLLOWS"


@dataclass(frozen=True, slots=True, eq=False)
class ActivePresentation:
    """Current presentation, with which the board's status is regularly compared.

    A new object is created for every presentation.
    """

    level: float  # mean, for a texture
    state: str = "HOLD"
    resettling_s: float = 0.3  # the board corrects its voltage when a finger comes or goes
    predicted_v: float | None = None  # from the calibration, for a texture's largest amplitude

    def what(self, quantity: Quantity) -> str:
        """Describe the commanded level."""
        level = quantity.short(self.level)
        return (
            Message("a texture with a mean of {level}", level=level)
            if self.state == "LIST"
            else level
        )


def check_status(
    status: BoardStatus, active: ActivePresentation, limits: PlateLimits, *, port: str
) -> None:
    """Raise a `PlateFault` if the status does not match the commanded presentation."""
    if status.state in SILENCED:
        fault, why = SILENCED[status.state]
        raise fault("{port}: {why}", port=port, why=why, level_free=True)
    measured_level, what = status.level, active.what(limits.quantity)
    if status.state == "SAT":
        unit = limits.quantity.unit_in_short
        reached = "less" if measured_level is None else f"{measured_level:.3f} {unit}"
        raise NotReached(
            "{what} was commanded, but the plate reaches {reached} at {voltage_v:.1f} V",
            what=what,
            reached=reached,
            voltage_v=status.voltage_v,
        )
    if active.state == FOLLOWS:
        return
    if status.state == "RAMP":
        raise NotReached(
            "{what} was commanded, but the plate does not settle at this level", what=what
        )
    if status.state != active.state:
        raise PlateRefused(
            "{port}: the board reports {state}, not {active_state}",
            port=port,
            state=status.state,
            active_state=active.state,
        )
    if measured_level is not None:
        limits.check_reached(active.level, measured_level)
    if active.predicted_v is not None:
        limits.check_predicted(
            active.level, reported_v=status.voltage_v, predicted_v=active.predicted_v
        )
