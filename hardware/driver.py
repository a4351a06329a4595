"""The plate driver: what every backend offers, and what is enforced for all of them.

One rule governs this file: **limits are checked here, before a backend hears of a command, and
every way out ends silent.** A command outside the limits raises and leaves the plate as it was.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, ClassVar, Literal, Protocol, Self

from faults import RigError, UserError

if TYPE_CHECKING:
    from types import TracebackType

    from hardware.clock import Clock
    from stimuli.surface import VirtualSurface

BACKENDS = "slipscale.backends"  # the entry-point group

ReadbackKind = Literal["measured", "applied", "commanded", "none"]


class PlateFault(RigError):
    """Something went wrong on the rig: ``code`` for the journal, ``remedy`` for the operator."""

    code: ClassVar[str] = "fault"
    remedy: ClassVar[str] = "see the message"

    def __init__(self, message: str) -> None:
        super().__init__(f"{message}. {self.remedy}")
        self.message = message


class PlateNotFound(PlateFault):
    """No device at that address."""

    code = "not_there"
    remedy = "Check the cable and the port's name: slipscale plate list shows the ports."


class WrongDevice(PlateFault):
    """A device answers, but it is not a plate, or not this plate."""

    code = "wrong_device"
    remedy = "Name the plate's own port, or the calibration that belongs to this plate."


class PlateBusy(PlateFault):
    """Another program holds the device, or the device does not accept commands."""

    code = "busy"
    remedy = "Close the other program that uses the plate, then try again."


class PlateTimeout(PlateFault):
    """No answer in the time agreed."""

    code = "time_out"
    remedy = "Check that the board has power, then unplug and replug it."


class GarbledReply(PlateFault):
    """An answer that cannot be read."""

    code = "garbled"
    remedy = "Check the cable and its distance from the amplifier."


class PlateRefused(PlateFault):
    """The device understood and said no."""

    code = "refused"
    remedy = "Let the board cool down or clear its error, then try again."


class ConnectionLost(PlateFault):
    """The device went away in the middle."""

    code = "lost"
    remedy = "Plug the plate in again; the session can reconnect."


class OverLimit(PlateFault):
    """A command outside the plate's limits; the plate was left as it was."""

    code = "over_limit"
    remedy = "Stay within the plate's limits, or correct them in the configuration."


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateLimits:
    """What a plate may be asked to do, for every backend.

    Parameters
    ----------
    amplitude_um_pp : float
        Largest vibration amplitude, µm peak to peak. The default leaves the paper's 2.3 µm at
        15 V (Section IV-A) in and little above.
    voltage_v : float
        Largest drive voltage, in the convention of the calibration (15 V in the paper,
        chosen "in order to avoid dangerous voltages", Section III-B).
    frequency_min_hz, frequency_max_hz : float
        The band in which the plate may be driven.
    duty : float
        Largest fraction of time that the plate may vibrate.
    on_time_s : float
        Longest uninterrupted vibration.
    """

    amplitude_um_pp: float = 2.5
    voltage_v: float = 16.5
    frequency_min_hz: float = 25_000.0
    frequency_max_hz: float = 40_000.0
    duty: float = 1.0
    on_time_s: float = 600.0

    def __post_init__(self) -> None:
        for name in self.__slots__:
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise UserError(f"plate limits: {name} is {value}, expected a positive number")
        if self.frequency_min_hz >= self.frequency_max_hz:
            raise UserError("plate limits: frequency_min_hz must lie below frequency_max_hz")

    def check_amplitude(self, amplitude_um_pp: float) -> None:
        """Raise `OverLimit` unless the amplitude is finite, not negative and within bounds."""
        if not (math.isfinite(amplitude_um_pp) and 0 <= amplitude_um_pp <= self.amplitude_um_pp):
            raise OverLimit(
                f"amplitude {amplitude_um_pp} µm p-p is outside 0 to {self.amplitude_um_pp} µm p-p"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateIdentity:
    """Who answers on the line (the four fields of IEEE 488.2 ``*IDN?``)."""

    manufacturer: str
    model: str
    serial: str
    firmware: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Readback:
    """What the plate says of itself; ``kind`` tells how far it can be trusted.

    ``amplitude_um_pp`` is None when ``kind`` is "none"; ``time_s`` is the host's clock.
    """

    amplitude_um_pp: float | None
    kind: ReadbackKind
    time_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Presentation:
    """A surface that has settled, and how that is known."""

    commanded_um_pp: float
    readback: Readback
    settled_by: Literal["readback", "wait"]
    settle_time_s: float


class PlateDriver(ABC):
    """A plate, whatever drives it. A context manager that ends silent on every path.

    Parameters
    ----------
    clock : Clock
        The only clock the driver may read.
    limits : PlateLimits
        Enforced here for every backend.
    """

    name: ClassVar[str]

    def __init__(self, *, clock: Clock, limits: PlateLimits | None = None) -> None:
        self.clock = clock
        self.limits = limits or PlateLimits()

    def present(self, surface: VirtualSurface) -> Presentation:
        """Make the surface: ramp to its amplitude and return once that has settled.

        Raises
        ------
        OverLimit
            The amplitude is outside the limits; the plate was left as it was.
        PlateFault
            Any other fault of the rig; the caller silences.
        """
        self.limits.check_amplitude(surface.amplitude_um_pp)
        return self._drive(surface.amplitude_um_pp)

    @abstractmethod
    def connect(self) -> PlateIdentity:
        """Open the line, check who answers, leave the plate silent."""

    @abstractmethod
    def _drive(self, amplitude_um_pp: float) -> Presentation:
        """Ramp to a checked amplitude; return when it has settled."""

    @abstractmethod
    def read_back(self) -> Readback:
        """Return what the plate does now. Raises `PlateFault` if it cannot say."""

    @abstractmethod
    def silence(self) -> None:
        """Stop the vibration. May be called at any time, in any state, more than once."""

    @abstractmethod
    def close(self) -> None:
        """Silence, then let go of the device. Never raises."""

    @abstractmethod
    def check(self) -> None:
        """Raise the `PlateFault` that has come up since the last command, if any.

        Called often (every frame) while a participant explores or answers: it must be cheap.
        """

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


class Backend(Protocol):
    """What an entry point of the group ``slipscale.backends`` is: it makes a driver."""

    def __call__(self, address: str, *, clock: Clock, seed: int) -> PlateDriver:
        """Return a driver, not yet connected.

        Parameters
        ----------
        address : str
            What follows the colon of the plate's SPEC: a port, a VISA resource, or "".
        clock : Clock
            The session's clock.
        seed : int
            For a backend that simulates; others ignore it.
        """


def backend_names() -> list[str]:
    """Return the names of all installed backends, sorted."""
    return sorted(entry_points(group=BACKENDS).names)


def open_plate(spec: str, *, clock: Clock, seed: int = 0) -> PlateDriver:
    """Return the driver that a SPEC names (``mock``, ``serial:PORT``, ``scpi:RESOURCE``).

    Raises
    ------
    UserError
        No backend of that name is installed.
    """
    name, _, address = spec.partition(":")
    found = {point.name: point for point in entry_points(group=BACKENDS)}
    if name not in found:
        raise UserError(f"plate '{spec}': no backend '{name}'; there are: {', '.join(found)}")
    backend: Backend = found[name].load()
    return backend(address, clock=clock, seed=seed)
