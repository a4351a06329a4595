"""What a driver board's status is checked against while it presents a surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

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

# Why a board that should vibrate does not.
SILENCED: dict[str, tuple[type[PlateFault], str]] = {
    "OFF": (ConnectionLost, "the board switched its output off by itself"),
    "WDOG": (PlateTimeout, "the board heard nothing from this computer and silenced the plate"),
    "HOT": (PlateRefused, "the board is too warm and silenced the plate"),
    "LONG": (OverLimit, "the board silenced the plate: it was on for too long"),
    "OPEN": (PlateRefused, "the board drives in open loop"),
}


# How many periods of a list the board may take until its mean is right again: it corrects by 5 % a
# period (four bring Q from 60 to 50), and a period is read when it is over.
CORRECTED_PERIODS = 6
# Not a state of the board: it follows a finger, between ramps, and nothing has settled.
FOLLOWS = "FOLLOWS"


@dataclass(frozen=True, slots=True, eq=False)
class ActivePresentation:
    """The presentation that the heartbeat checks; each is a new object."""

    amplitude_um_pp: float  # of a texture the mean
    state: str = "HOLD"
    resettling_s: float = 0.3  # when a finger comes or goes, the board corrects its voltage
    predicted_v: float | None = None  # by the calibration; of a texture for its largest amplitude

    @property
    def what(self) -> str:
        """What was commanded."""
        mean = "a texture of mean " if self.state == "LIST" else ""
        return f"{mean}{self.amplitude_um_pp:g} µm p-p"


def check_status(
    status: BoardStatus, active: ActivePresentation, limits: PlateLimits, *, port: str
) -> None:
    """Raise a `PlateFault` unless the plate makes what was commanded."""
    if status.state in SILENCED:
        fault, why = SILENCED[status.state]
        raise fault(f"{port}: {why}")
    measured_um_pp = status.amplitude_um_pp
    if status.state == "SAT":
        reached = "less" if measured_um_pp is None else f"{measured_um_pp:.3f} µm p-p"
        raise NotReached(
            f"{active.what} was commanded, {reached} is all that {status.voltage_v:.1f} V give"
        )
    if active.state == FOLLOWS:
        return
    if status.state == "RAMP":
        raise NotReached(f"{active.what} was commanded, and the plate does not settle there")
    if status.state != active.state:
        raise PlateRefused(f"{port}: the board tells {status.state}, not {active.state}")
    if measured_um_pp is not None:
        limits.check_reached(active.amplitude_um_pp, measured_um_pp)
    if active.predicted_v is not None:
        limits.check_predicted(
            active.amplitude_um_pp, reported_v=status.voltage_v, predicted_v=active.predicted_v
        )
