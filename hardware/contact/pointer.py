"""Read the finger's position from the pointer in the participant's window.

SPEC: ``mouse:mm_per_pixel=0.25`` with

================  ===============================================================
``mm_per_pixel``  finger movement per pixel of pointer movement; required:
                  measure it with the pointer's acceleration switched off
``angle``         direction of the stroke on the screen, degrees (0: to the right)
================  ===============================================================

The pointer is a mouse, or a touch panel that acts as a mouse, and provides one sample per frame.
The origin is the middle of the window.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import ClassVar

from slipscale.faults import UserError
from slipscale.hardware import address as addresses
from slipscale.hardware.contact.source import POSITION, ContactSource, Sample, Surroundings

OPTIONS: dict[str, Callable[[str], object]] = {
    "mm_per_pixel": addresses.positive_number,
    "angle": addresses.number,
}


class WindowPointer(ContactSource):
    """Pointer position, in mm along and across the stroke.

    Parameters
    ----------
    surroundings : Surroundings
        Properties of the session; the ``finger`` must be a window's pointer.
    mm_per_pixel : float
    angle_deg : float
        Direction of the stroke on the screen.
    """

    name: ClassVar[str] = "mouse"
    quantities = POSITION

    def __init__(
        self, surroundings: Surroundings, *, mm_per_pixel: float, angle_deg: float = 0.0
    ) -> None:
        finger = surroundings.finger
        if finger is None or finger.unit != "px":
            raise UserError("--position mouse: there is no window that provides a pointer")
        self._finger = finger
        self._clock = surroundings.clock
        self._mm_per_pixel = mm_per_pixel
        self._angle_deg = angle_deg

    def connect(self) -> None:
        """Do nothing, because the window is already open."""

    def take(self) -> list[Sample]:
        """Return the current position of the pointer."""
        now_s = self._clock.now()
        touch = self._finger.at(now_s)
        if touch is None:
            return []
        turn = math.radians(self._angle_deg)
        along = touch.x * math.cos(turn) + touch.y * math.sin(turn)
        across = touch.y * math.cos(turn) - touch.x * math.sin(turn)
        return [Sample(now_s, (along * self._mm_per_pixel, across * self._mm_per_pixel))]

    def close(self) -> None:
        """Do nothing."""

    def describe(self) -> dict[str, object]:
        """Return the source's name, scale and angle."""
        return {
            "name": self.name,
            "mm_per_pixel": self._mm_per_pixel,
            "angle_deg": self._angle_deg,
        }


def open_position(address: str, surroundings: Surroundings) -> ContactSource:
    """Return the pointer as a position source (entry point ``mouse``). Raises `UserError`."""
    _, options = addresses.split_address(address, OPTIONS, what="--position mouse")
    if "mm_per_pixel" not in options:
        raise UserError(
            "--position 'mouse:{address}': expected mm_per_pixel=..., the measured finger "
            "movement per pixel",
            address=address,
        )
    return WindowPointer(
        surroundings,
        mm_per_pixel=options["mm_per_pixel"],
        angle_deg=options.get("angle", 0.0),
    )
