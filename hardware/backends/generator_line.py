"""Communicate with a function generator through PyVISA; all failures raise `PlateFault`.

Many instruments accept a single connection. In a session, the guard process therefore owns the
connection (`GuardedGenerator`), and the session sends its commands through the guard
(`RelayedLine`).
"""

from __future__ import annotations

import re
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Protocol

from slipscale.hardware.errors import ConnectionLost, PlateBusy, PlateNotFound, PlateTimeout

TIMEOUT_MS = 1_000
BAUD = 115_200  # if the resource is a serial port


class Line(Protocol):
    """Interface for connections to a generator; all methods raise `PlateFault`."""

    resource: str

    @property
    def opened(self) -> bool:
        """Whether the connection is open."""

    def open(self) -> None:
        """Open the resource."""

    def release(self) -> None:
        """Release the resource."""

    def write(self, command: str) -> None:
        """Send a command."""

    def ask(self, query: str) -> str:
        """Send a query and return the answer."""


class RelayedLine:
    """Connection that the guard process holds.

    Parameters
    ----------
    resource : str
        VISA resource or serial port.

    Attributes
    ----------
    relay : callable
        Function that calls a method of the `GuardedGenerator`; set by the driver.
    """

    relay: Callable[..., str]

    def __init__(self, resource: str) -> None:
        self.resource = visa_resource(resource)
        self.opened = False

    def open(self) -> None:
        """Open the resource. Raises `PlateNotFound`."""
        self.relay("open")
        self.opened = True

    def release(self) -> None:
        """Release the resource."""
        if self.opened:
            self.opened = False
            self.relay("release")

    def write(self, command: str) -> None:
        """Send a command. Raises `PlateFault`."""
        self.relay("write", command)

    def ask(self, query: str) -> str:
        """Send a query and return the answer. Raises `PlateFault`."""
        return self.relay("ask", query)


def visa_resource(text: str) -> str:
    """Return the VISA resource for a resource or a serial port."""
    return text if "::" in text else f"ASRL{text}::INSTR"


#: The number of the first interface of a kind, which may be omitted (but not that of the tenth).
BOARD_0 = re.compile(r"(?<=[A-Z])0$")


def instrument_of(resource: str) -> str:
    """Return one name for all VISA resources that lead to the same instrument.

    >>> instrument_of("tcpip0::127.0.0.1::inst0::INSTR") == instrument_of("TCPIP::localhost::INSTR")
    True
    >>> instrument_of("USB0::0x0957::0x2C07::MY1::0::INSTR")
    'USB::2391::11271::MY1'
    """
    interface, *parts = resource.split("::")
    if interface.upper().startswith("ASRL"):
        port = interface[4:]
        return f"ASRL{Path(port).resolve() if Path(port).exists() else port.upper()}"
    interface = BOARD_0.sub("", interface.upper())
    if interface == "TCPIP" and parts:
        with suppress(OSError):
            parts[0] = socket.gethostbyname(parts[0])
    numbers = (_decimal(part) for part in parts)
    kept = [part for part in numbers if interface == "TCPIP" or part != "0"]
    kept = [part.upper() for part in kept if part.upper() not in {"INST0", "INSTR"}]
    return "::".join([interface, *kept])


def _decimal(part: str) -> str:
    return str(int(part, 16)) if part.lower().startswith("0x") else part


class GeneratorLine:
    """Connection to a generator that accepts commands and answers queries.

    Parameters
    ----------
    resource : str
        VISA resource or serial port.
    visa_library : str
        Backend of PyVISA. The backend ``@py`` requires no vendor library.
    """

    def __init__(self, resource: str, visa_library: str = "@py") -> None:
        self.resource = visa_resource(resource)
        self._visa_library = visa_library
        self._instrument: Any = None

    @property
    def opened(self) -> bool:
        """Whether the connection is open."""
        return self._instrument is not None

    def open(self) -> None:
        """Open the resource. Raises `PlateNotFound`."""
        # Importing PyVISA takes a third of a second.
        from pyvisa import ResourceManager

        on_port = self.resource.upper().startswith("ASRL")
        serial: dict[str, Any] = {"baud_rate": BAUD} if on_port else {}
        with self._told_as_faults(opening=True):
            self._instrument = ResourceManager(self._visa_library).open_resource(
                self.resource,
                timeout=TIMEOUT_MS,
                open_timeout=TIMEOUT_MS,
                read_termination="\n",
                write_termination="\n",
                **serial,
            )
            self._lock(self._instrument)

    def _lock(self, instrument: Any) -> None:
        """Lock the instrument against other computers, if it supports locks. Raises `PlateBusy`."""
        from pyvisa.constants import StatusCode
        from pyvisa.errors import VisaIOError

        try:
            instrument.lock_excl(timeout=TIMEOUT_MS)
        except VisaIOError as error:
            if error.error_code == StatusCode.error_resource_locked:
                self.release()
                raise PlateBusy(
                    "{resource}: another program has locked it", resource=self.resource
                ) from error

    def release(self) -> None:
        """Release the resource."""
        instrument, self._instrument = self._instrument, None
        if instrument is not None:
            with self._told_as_faults():
                instrument.close()

    def write(self, command: str) -> None:
        """Send a command. Raises `PlateFault`."""
        with self._told_as_faults():
            self._require().write(command)

    def ask(self, query: str) -> str:
        """Send a query and return the answer. Raises `PlateFault`."""
        with self._told_as_faults():
            return str(self._require().query(query)).strip()

    def _require(self) -> Any:
        if self._instrument is None:
            raise ConnectionLost("{resource}: not connected", resource=self.resource)
        return self._instrument

    @contextmanager
    def _told_as_faults(self, *, opening: bool = False) -> Iterator[None]:
        from pyvisa.constants import StatusCode
        from pyvisa.errors import VisaIOError

        try:
            yield
        except (VisaIOError, OSError, ValueError) as error:
            if opening:
                raise PlateNotFound(
                    "{resource}: cannot be opened ({error})", resource=self.resource, error=error
                ) from error
            if getattr(error, "error_code", None) == StatusCode.error_timeout:
                raise PlateTimeout(
                    "{resource}: the generator does not answer", resource=self.resource
                ) from error
            raise ConnectionLost(
                "{resource}: the device was disconnected ({error})",
                resource=self.resource,
                error=error,
            ) from error
