"""Records that a plate reports: identity, output, readback and presentation.

`hardware.driver` re-exports them.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

# Prefix of an emulated board's serial number.
EMULATED = "EMULATED"

ReadbackKind = Literal["measured", "applied", "commanded", "none"]


class Output(StrEnum):
    """The known state of a plate's drive; see the rules in `slipscale.hardware.output_state`."""

    OFF = "confirmed off"
    MAY_BE_ON = "may be on"
    UNREACHABLE = "unreachable"


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateIdentity:
    """The device's identity (the four fields of IEEE 488.2 ``*IDN?``)."""

    manufacturer: str
    model: str
    serial: str
    firmware: str

    @property
    def emulated(self) -> bool:
        """Whether a program emulates the board, so that a finger would feel nothing."""
        return self.serial.startswith(EMULATED)


@dataclass(frozen=True, slots=True, kw_only=True)
class Readback:
    """The plate's reported state; ``kind`` states how reliable the readback is.

    "measured": by a sensor; "applied": computed from the active drive; "commanded": only an echo;
    "none": ``level`` is None. ``time_s`` is the host's clock. The drive voltage at the plate (the
    largest, for a texture) and the temperature are None if unknown.
    """

    level: float | None
    kind: ReadbackKind
    time_s: float
    voltage_v_peak: float | None = None
    temperature_c: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Presentation:
    """A settled surface, with the evidence for it.

    ``predicted_v_peak`` is the voltage at the plate that the calibration predicts for the
    amplitude, None without a calibration; ``readback.voltage_v_peak`` is the reported one.
    ``second_readback_level`` is the readback of a second actuator.
    """

    commanded_level: float
    readback: Readback
    settled_by: Literal["readback", "wait"]
    settle_time_s: float
    predicted_v_peak: float | None = None
    second_readback_level: float | None = None
