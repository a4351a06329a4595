"""Whether a driver board makes what it was told to: what its status is judged by."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hardware.errors import (
    ConnectionLost,
    NotReached,
    OverLimit,
    PlateFault,
    PlateRefused,
    PlateTimeout,
)

if TYPE_CHECKING:
    from hardware.backends.serial_board.protocol import Status
    from hardware.limits import PlateLimits

# Why a board that should vibrate does not.
SILENCED: dict[str, tuple[type[PlateFault], str]] = {
    "OFF": (ConnectionLost, "the board switched its output off by itself"),
    "WDOG": (PlateTimeout, "the board heard nothing from this computer and silenced the plate"),
    "HOT": (PlateRefused, "the board is too warm and silenced the plate"),
    "LONG": (OverLimit, "the board silenced the plate: it was on for too long"),
    "OPEN": (PlateRefused, "the board drives in open loop"),
}


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """One presentation that the heartbeat watches over; each is a new object."""

    amplitude_um_pp: float  # of a texture the mean
    state: str = "HOLD"

    @property
    def what(self) -> str:
        """What was commanded."""
        mean = "a texture of mean " if self.state == "LIST" else ""
        return f"{mean}{self.amplitude_um_pp:g} µm p-p"


def judge(status: Status, held: Held, limits: PlateLimits, *, port: str) -> None:
    """Raise a `PlateFault` unless the plate makes what was commanded."""
    if status.state in SILENCED:
        fault, why = SILENCED[status.state]
        raise fault(f"{port}: {why}")
    if status.state == "SAT":
        raise NotReached(
            f"{held.what} was commanded, {status.amplitude_um_pp:.3f} µm p-p is all that "
            f"{status.voltage_v:.1f} V give"
        )
    if status.state != held.state:
        raise PlateRefused(f"{port}: the board tells {status.state}, not {held.state}")
    limits.check_reached(held.amplitude_um_pp, status.amplitude_um_pp)
