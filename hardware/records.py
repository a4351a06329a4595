"""What a plate reports: identity, output, readback, presentation; `hardware.driver` offers them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

# What an emulated board has for the beginning of its serial number.
EMULATED = "EMULATED"

ReadbackKind = Literal["measured", "applied", "commanded", "none"]


class Output(StrEnum):
    """What is known about a plate's drive; `slipscale.hardware.output_state` states the rules."""

    OFF = "confirmed off"
    MAY_BE_ON = "may be on"
    UNREACHABLE = "unreachable"


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateIdentity:
    """Who answers on the line (the four fields of IEEE 488.2 ``*IDN?``)."""

    manufacturer: str
    model: str
    serial: str
    firmware: str

    @property
    def emulated(self) -> bool:
        """Whether a program answers in a board's place: a finger would feel nothing."""
        return self.serial.startswith(EMULATED)


@dataclass(frozen=True, slots=True, kw_only=True)
class Readback:
    """What the plate says of itself; ``kind`` tells how far it can be trusted.

    "measured" by a sensor; "applied": worked out from the drive that is on; "commanded": only an
    echo; "none": ``level`` is None. ``time_s`` is the host's clock. The drive voltage at
    the plate (of a texture the largest) and the temperature are None where they are not known.
    """

    level: float | None
    kind: ReadbackKind
    time_s: float
    voltage_v_peak: float | None = None
    temperature_c: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Presentation:
    """A surface that has settled, and how that is known.

    ``predicted_v_peak`` is the voltage at the plate that the calibration predicts for the
    amplitude, None without a calibration; ``readback.voltage_v_peak`` is the reported one.
    """

    commanded_level: float
    readback: Readback
    settled_by: Literal["readback", "wait"]
    settle_time_s: float
    predicted_v_peak: float | None = None
