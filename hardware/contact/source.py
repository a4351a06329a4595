"""Define the interface for sources of finger position or force.

While the participant explores or answers, all samples since the last query are requested in each
video frame. Each sample has a time stamp, so a source can sample faster than the frame rate.
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
# Quantities of position and force sources. x is along the stroke, y across it.
POSITION: Quantities = ("x_mm", "y_mm")
FORCE: Quantities = ("normal_n", "lateral_n")
Kind = Sensor
QUANTITIES: dict[Kind, Quantities] = {"position": POSITION, "force": FORCE}


class SensorFault(PlateFault):
    """Raised if a source is disconnected or sends no valid data."""

    code = "sensor"
    never_a_level = True
    remedy = "Check the sensor's cable and its SPEC; slipscale check shows its readings."


class Sample(NamedTuple):
    """One reading: its session time, and its values in the order of the source's quantities."""

    time_s: float
    values: tuple[float, ...]


class Touch(NamedTuple):
    """State of a finger that touches the plate.

    ``x`` and ``y`` are in mm or, for a window's pointer, in pixels from the middle of the window.
    The force is known only for a simulated finger.
    """

    x: float
    y: float
    normal_n: float = 0.0


class Finger(Protocol):
    """Interface for the finger, which is a window's pointer or a simulated participant's finger."""

    unit: Literal["mm", "px"]

    def at(self, time_s: float) -> Touch | None:
        """Return the finger's state at a session time, or None if it does not touch the plate.

        For a window's pointer, only the current position is known. For a simulated finger, all
        positions since the start of the exploration are known.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """Properties of a session that a source of position or force may require.

    Parameters
    ----------
    clock : Clock
        Clock for the time stamps of samples.
    seed : int
        Random seed for a simulated source.
    participant : str
        Label of the simulated participant.
    finger : Finger or None
        Window's pointer or simulated finger, for sources that read it instead of a device.
    vibration_level : callable or None
        Function that returns the current amplitude in µm peak to peak; used by simulated forces.
    """

    clock: Clock
    seed: int = 0
    participant: str = ""
    finger: Finger | None = None
    vibration_level: Callable[[], float] | None = None


class ContactSource(ABC):
    """Base class of sources of position or force: a context manager that releases the device.

    Attributes
    ----------
    quantities : tuple of str
        Name and unit of each value in a sample: `POSITION` or `FORCE`.
    unreadable : int
        Number of invalid readings so far.
    virtual : bool
        Whether the source supports a pilot's virtual time.
    """

    name: ClassVar[str]
    quantities: Quantities
    unreadable: int = 0
    virtual: ClassVar[bool] = False

    @abstractmethod
    def connect(self) -> None:
        """Open the device and wait for its first reading. Raises `SensorFault`."""

    def begin(self) -> None:
        """Start sampling and discard earlier samples; reconnect the device if it was lost."""
        self.take()

    @abstractmethod
    def take(self) -> list[Sample]:
        """Return the samples since the last call, in order of time. Raises `SensorFault`."""

    @abstractmethod
    def close(self) -> None:
        """Release the device; safe to call at any time."""

    def describe(self) -> dict[str, object]:
        """Return the description for the session's record, as JSON data."""
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
