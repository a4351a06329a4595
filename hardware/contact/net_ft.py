"""Read forces from an ATI Net F/T box over a network.

SPEC: ``ati:HOST,option=value,...``

=================================  ============================================================
``counts_per_n``                   counts per newton; required: "Counts per Force" on the box's
                                   page "Configurations", with N as the unit of force
``normal``, ``lateral``            axis and sign: ``x``, ``-x``, ``y``, ... (``-z`` and ``x``)
``tare``                           seconds at the start without a finger on the plate; their mean
                                   becomes the zero (0: none)
``port``                           UDP port of the box (49152)
=================================  ============================================================

The box sends one record per datagram (Raw Data Transfer, RDT). Set its output rate to 1000 Hz: the
default of 7000 Hz is more than Python reads without losses. Records that are lost, late or report
an error of the transducer are counted as unreadable. **Not yet tested with a real box.**
"""

from __future__ import annotations

import socket
import struct
from collections.abc import Callable
from contextlib import suppress
from typing import ClassVar, NamedTuple, Self

from slipscale.faults import UserError
from slipscale.hardware import address as addresses
from slipscale.hardware.backends.serial_board.link import Line
from slipscale.hardware.clock import Clock
from slipscale.hardware.contact.serial_columns import Channel, SerialColumns, seconds
from slipscale.hardware.contact.source import (
    FORCE,
    ContactSource,
    SensorFault,
    Surroundings,
)

PORT = 49152
HEADER = 0x1234
STOP, STREAM = 0, 2
REQUEST = struct.Struct(">HHI")  # header, command, number of records (0: until stopped)
RECORD = struct.Struct(
    ">III6i"
)  # sequence, internal sequence, status, counts of forces and torques
WAIT_S = 0.05
SEQUENCES = 2**32
AXES = {f"{sign}{axis}": (place, sign) for sign in ("", "-") for place, axis in enumerate("xyz", 1)}


class Record(NamedTuple):
    """One record of the box: its number, its status (0: healthy) and six counts."""

    sequence: int
    status: int
    counts: tuple[int, ...]

    @classmethod
    def read(cls, data: bytes) -> Self:
        """Decode a datagram. Raises `struct.error` if its length is wrong."""
        sequence, _, status, *counts = RECORD.unpack(data)
        return cls(sequence, status, tuple(counts))


class Datagrams:
    """The box's datagrams as a `Line`: one record per read. Raises `SensorFault`.

    Parameters
    ----------
    host : str
    port : int
    """

    def __init__(self, host: str, port: int) -> None:
        self.port = host
        self._socket: socket.socket | None = None
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
            family, kind, _, _, place = found[0]
            self._socket = socket.socket(family, kind)
            self._socket.settimeout(WAIT_S)
            self._socket.connect(place)  # datagrams from other computers are ignored
            self.write(REQUEST.pack(HEADER, STREAM, 0))
        except OSError as error:
            self.close()
            raise self._lost(error) from error

    def write(self, data: bytes) -> None:
        """Send a request."""
        if self._socket is not None:
            self._socket.send(data)

    def read(self) -> bytes:
        """Return the next datagram, or b"" after a short time without one."""
        if self._socket is None:
            return b""
        try:
            return self._socket.recv(4 * RECORD.size)
        except TimeoutError:
            return b""
        except OSError as error:
            raise self._lost(error) from error

    def close(self) -> None:
        """Ask the box to stop, and release the socket."""
        line, self._socket = self._socket, None
        if line is not None:
            with suppress(OSError):  # the box is gone
                line.send(REQUEST.pack(HEADER, STOP, 0))
            line.close()

    def _lost(self, error: OSError) -> SensorFault:
        return SensorFault(
            "ati {host}: no connection ({reason})", host=self.port, reason=error.strerror or error
        )


class NetForces(SerialColumns):
    """Forces of an ATI Net F/T box. A separate thread receives the datagrams.

    Parameters
    ----------
    host : str
    port : int
    clock : Clock
    channels : list of Channel
        Place (1 to 3: x, y, z), N per count and zero of the normal and of the lateral force.
    tare_s : float
        As for `SerialColumns`.
    """

    name: ClassVar[str] = "ati"

    def __init__(
        self, host: str, port: int, *, clock: Clock, channels: list[Channel], tare_s: float
    ) -> None:
        super().__init__(
            self.name, host, clock=clock, quantities=FORCE, channels=channels, tare_s=tare_s
        )
        self._udp_port = port
        self._last: int | None = None

    def _open(self) -> Line:
        self._last = None  # the box counts from 1 when it starts
        return Datagrams(self.port, self._udp_port)

    def _readings(self, data: bytes) -> list[tuple[float, ...]]:
        if not data:
            return []
        try:
            record = Record.read(data)
        except struct.error:
            return self._refused(f"{len(data)} bytes")
        step = 1 if self._last is None else (record.sequence - self._last) % SEQUENCES
        if not 0 < step < SEQUENCES // 2:  # twice, or after a newer one
            return self._refused(f"record {record.sequence} after {self._last}")
        self.unreadable += step - 1
        self._last = record.sequence
        if record.status:
            return self._refused(f"status 0x{record.status:08x}")
        counts = [float(each) for each in record.counts]
        return [tuple(channel.value(counts) for channel in self._channels)]

    def _refused(self, what: str) -> list[tuple[float, ...]]:
        self.unreadable += 1
        self._last_unreadable = what
        return []


def _axis(text: str) -> tuple[int, str]:
    if text not in AXES:
        raise ValueError("expected one of x, y, z, -x, -y, -z")
    return AXES[text]


def _port(text: str) -> int:
    value = addresses.positive_number(text)
    if value != int(value) or value >= 2**16:
        raise ValueError("expected a whole number from 1 to 65535")
    return int(value)


OPTIONS: dict[str, Callable[[str], object]] = {
    "counts_per_n": addresses.positive_number,
    "normal": _axis,
    "lateral": _axis,
    "tare": seconds,
    "port": _port,
}


def open_force(address: str, surroundings: Surroundings) -> ContactSource:
    """Return a source of forces (entry point ``ati``). Raises `UserError`."""
    host, options = addresses.split_address(address, OPTIONS, what="--force ati")
    if not host or "counts_per_n" not in options:
        raise UserError(
            "--force 'ati:{address}': expected ati:HOST,counts_per_n=N, with the box's counts per "
            "newton",
            address=address,
        )
    axes = (options.get("normal", AXES["-z"]), options.get("lateral", AXES["x"]))
    if axes[0][0] == axes[1][0]:
        raise UserError(
            "--force 'ati:{address}': normal and lateral force need two axes", address=address
        )
    channels = [
        Channel(place, (-1.0 if sign else 1.0) / options["counts_per_n"], 0.0)
        for place, sign in axes
    ]
    return NetForces(
        host,
        options.get("port", PORT),
        clock=surroundings.clock,
        channels=channels,
        tare_s=options.get("tare", 0.0),
    )
