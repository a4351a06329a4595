"""The gain between what a backend drives and the plate: told by whom, and told once."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.hardware.calibration.record import Calibration


def agreed_gain(
    given: float | None, wired: float | None, calibration: Calibration | None, *, unknown: str
) -> float:
    """Return the gain, which must not be guessed: it multiplies the plate's volts.

    Parameters
    ----------
    given, wired : float
        As the SPEC and the plate file say it.
    calibration : Calibration
        Was made with a gain.
    unknown : str
        What to tell where nobody says it; begins with the backend, up to the first colon.

    Raises
    ------
    UserError
        No gain is known, or two that differ.
    """
    calibrated = calibration.drive.amplifier_gain if calibration else None
    told = {
        source: gain
        for source, gain in (
            ("the SPEC says", given),
            ("the plate file says", wired),
            ("the calibration was made with", calibrated),
        )
        if gain is not None
    }
    if not told:
        raise UserError(unknown)
    gains = list(told.values())
    if not all(math.isclose(gains[0], each) for each in gains):
        sources = ", ".join(f"{source} {gain:g}" for source, gain in told.items())
        backend = unknown.partition(":")[0]
        raise UserError(f"{backend}: the amplifier's gain is told in two ways: {sources}")
    return gains[0]
