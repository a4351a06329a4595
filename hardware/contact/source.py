"""The interface of a source of finger position or force.

At every frame of a participant's step, a source is queried for the samples since the last query.
Each sample has the session's time, so a source that samples faster than the frames loses nothing.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Literal, NamedTuple, Protocol, Self

from slipscale.hardware.clock import Clock
from slipscale.hardware.errors import PlateFault
from slipscale.stimuli.surface import Sensor

Quantities = tuple[str, ...]
# Quantities of position and force sources. x is along the stroke, y across.
POSITION: Quantities = ("x_mm", "y_mm")
FORCE: Quantities = ("normal_n", "lateral_n")
Kind = Sensor
QUANTITIES: dict[Kind, Quantities] = {"position": POSITION, "force": FORCE}


class SensorFault(PlateFault):
    """A source of position or force has disappeared, or sends nothing readable."""

    code = "sensor"
    remedy = "Check the sensor's cable and its SPEC; slipscale check shows its readings."


class Sample(NamedTuple):
    """One reading: the session's time, and the source's quantities in order."""

    time_s: float
    values: tuple[float, ...]


class Touch(NamedTuple):
    """A finger on the plate.

    ``x`` and ``y`` are in mm or, for a window's pointer, in pixels from its middle. The force is
    known only for a simulated finger.
    """

    x: float
    y: float
    normal_n: float = 0.0


class Finger(Protocol):
    """Provides the finger's position: a window's pointer, or a simulated participant's finger."""

    unit: Literal["mm", "px"]

    def at(self, time_s: float) -> Touch | None:
        """Return the finger's state at a session time; None if it does not touch.

        A window only has the current position. For a simulated finger, any time since the
        beginning of its exploration is possible.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """The session's properties that a source may require.

    Parameters
    ----------
    clock : Clock
        Time base of the samples.
    seed : int
        Random seed of a simulated source.
    participant : str
        The simulated participant.
    finger : Finger or None
        The finger, for sources that obtain the position from the window or the simulated
        participant.
    vibration_level : callable or None
        Returns what a finger on the plate feels now, µm peak to peak; for a simulated force.
    """

    clock: Clock
    seed: int = 0
    participant: str = ""
    finger: Finger | None = None
    vibration_level: Callable[[], float] | None = None


class ContactSource(ABC):
    """A source of position or force. A context manager that always releases the device.

    Attributes
    ----------
    quantities : tuple of str
        Names and units of a sample's values: `POSITION` or `FORCE`.
    unreadable : int
        Number of unreadable readings so far; they are not samples.
    virtual : bool
        Whether it works in a pilot's virtual time.
    """

    name: ClassVar[str]
    quantities: Quantities
    unreadable: int = 0
    virtual: ClassVar[bool] = False

    @abstractmethod
    def connect(self) -> None:
        """Open the device and wait for its first reading. Raises `SensorFault`."""

    def begin(self) -> None:
        """Start sampling and discard earlier samples. A lost device is reconnected."""
        self.take()

    @abstractmethod
    def take(self) -> list[Sample]:
        """Return the samples since the last call, in order. Raises `SensorFault`."""

    @abstractmethod
    def close(self) -> None:
        """Release the device; may be called at any time."""

    def describe(self) -> dict[str, object]:
        """Return the source's entry in the session's record, ready for JSON."""
        return {"name": self.name}

    def __enter__(self) -> Self:
        try:
            self.connect()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()
