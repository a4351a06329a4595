"""A source of what the finger does: its place, or its forces. What every source offers.

A source is asked at every frame of a participant's step for the samples that came since it was
last asked. Each sample carries the session's time, so that one that samples faster than the frames
loses nothing.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple, Protocol, Self

from slipscale.hardware.errors import PlateFault

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import TracebackType

    from slipscale.hardware.clock import Clock

Quantities = tuple[str, ...]
# What a position source and a force source measure. x runs along the stroke, y across.
POSITION: Quantities = ("x_mm", "y_mm")
FORCE: Quantities = ("normal_n", "lateral_n")
Kind = Literal["position", "force"]
QUANTITIES: dict[Kind, Quantities] = {"position": POSITION, "force": FORCE}


class SensorFault(PlateFault):
    """A source of position or force has gone, or tells nothing that can be read."""

    code = "sensor"
    remedy = "Check the sensor's cable and its SPEC: slipscale check shows what it tells."


class Sample(NamedTuple):
    """One reading: the session's time, and the source's quantities in their order."""

    time_s: float
    values: tuple[float, ...]


class Touch(NamedTuple):
    """A finger on the plate.

    ``x`` and ``y`` are in mm, or for a window's pointer in pixels from its middle; the force is
    known of a simulated finger only.
    """

    x: float
    y: float
    normal_n: float = 0.0


class Finger(Protocol):
    """Who has the finger: a window knows its pointer, a simulated participant its own."""

    unit: Literal["mm", "px"]

    def at(self, time_s: float) -> Touch | None:
        """Return where it is at a time of the session; None where it does not touch.

        A window knows only now. A simulated finger can be asked of all the time since its
        exploration began.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """What a source may need of the session that it is used in.

    Parameters
    ----------
    clock : Clock
        Its samples are on this clock.
    seed : int
        For a source that simulates.
    participant : str
        Whom it simulates.
    finger : Finger or None
        For the sources that ask who has the finger.
    vibration_level : callable or None
        Returns what a finger on the plate feels now, µm peak to peak; for a simulated force.
    """

    clock: Clock
    seed: int = 0
    participant: str = ""
    finger: Finger | None = None
    vibration_level: Callable[[], float] | None = None


class ContactSource(ABC):
    """A source of position or force. A context manager that lets go of the device on every path.

    Attributes
    ----------
    quantities : tuple of str
        What a sample's values are, with their units: `POSITION` or `FORCE`.
    unreadable : int
        How many readings could not be read so far; they are no samples.
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
        """Begin to sample: what came before is dropped. A lost device is connected again."""
        self.take()

    @abstractmethod
    def take(self) -> list[Sample]:
        """Return the samples since the last call, in order. Raises `SensorFault`."""

    @abstractmethod
    def close(self) -> None:
        """Let go of the device; may be called at any time."""

    def describe(self) -> dict[str, object]:
        """Return what a record of the session should say of the source, ready for JSON."""
        return {"name": self.name}

    def __enter__(self) -> Self:
        try:
            self.connect()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
