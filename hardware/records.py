"""Define the records reported by a plate: identity, output, readback and presentation."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

# Prefix of an emulated board's serial number.
EMULATED = "EMULATED"

ReadbackKind = Literal["measured", "applied", "commanded", "none"]


class Output(StrEnum):
    """Known state of a plate's drive; for the rules, see `slipscale.hardware.output.state`."""

    OFF = "confirmed off"
    MAY_BE_ON = "may be on"
    UNREACHABLE = "unreachable"


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateIdentity:
    """Device identity: the four fields of an IEEE 488.2 answer to ``*IDN?``."""

    manufacturer: str
    model: str
    serial: str
    firmware: str

    @property
    def emulated(self) -> bool:
        """Whether the board is emulated, so that a finger would feel nothing."""
        return self.serial.startswith(EMULATED)


@dataclass(frozen=True, slots=True, kw_only=True)
class Readback:
    """State reported by the plate; ``kind`` describes how reliable it is.

    A level is "measured" by a sensor, "applied" if computed from the active drive, "commanded" if
    it only repeats the command, or "none" if ``level`` is None. ``time_s`` is the time on the
    host's clock. The drive voltage at the plate (for a texture, the largest) and the temperature
    are None if unknown.
    """

    level: float | None
    kind: ReadbackKind
    time_s: float
    voltage_v_peak: float | None = None
    temperature_c: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Presentation:
    """Result of presenting a surface: the readback after the plate has settled.

    ``predicted_v_peak`` is the voltage at the plate that the calibration predicts for the
    amplitude, or None without a calibration. ``second_readback_level`` is a second actuator's
    readback.
    """

    commanded_level: float
    readback: Readback
    settled_by: Literal["readback", "wait"]
    settle_time_s: float
    predicted_v_peak: float | None = None
    second_readback_level: float | None = None
