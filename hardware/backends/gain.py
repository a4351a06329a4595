"""Determine the gain between the output of a backend and the plate."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.hardware.address import Plate


def agreed_gain(given: float | None, plate: Plate, *, unknown: str) -> float:
    """Return the gain on which all given sources agree.

    Parameters
    ----------
    given : float
        Gain in the SPEC.
    plate : Plate
        Plate, whose file may state a gain; its calibration records the gain it was made with.
    unknown : str
        Error message if no source defines the gain. It must start with the backend's name and a
        colon.

    Raises
    ------
    UserError
        If the gain is unknown, or two sources disagree.
    """
    wired = plate.file.wiring.amplifier_gain if plate.file else None
    calibrated = plate.calibration.drive.amplifier_gain if plate.calibration else None
    stated = {
        source: gain
        for source, gain in (
            ("the SPEC has", given),
            ("the plate file has", wired),
            ("the calibration was made with", calibrated),
        )
        if gain is not None
    }
    if not stated:
        raise UserError(unknown)
    gains = list(stated.values())
    if not all(math.isclose(gains[0], each) for each in gains):
        sources = ", ".join(f"{source} {gain:g}" for source, gain in stated.items())
        backend = unknown.partition(":")[0]
        raise UserError(
            "{backend}: two different values for the amplifier's gain: {sources}",
            backend=backend,
            sources=sources,
        )
    return gains[0]
