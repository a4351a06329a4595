"""A computer with its driver boards and sensors in virtual time, in one process.

Time advances only while the driver or a test waits: in ticks of a millisecond, in each of which all
devices run. Regular calls of the driver, such as its heartbeat, run when they are due during
`VirtualTime.sleep`. A time-out of 60 ms is therefore 60 virtual milliseconds on every machine.
"""

from __future__ import annotations

import json
import math
from abc import ABC, abstractmethod
from argparse import ArgumentParser
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from slipscale.hardware.backends.serial_board.serial_line import BAUD
from slipscale.hardware.cli import emulate
from slipscale.hardware.emulator import compiled, console
from slipscale.hardware.errors import ConnectionLost, PlateBusy, PlateNotFound
from tests.support.controlled_board import ControlledBoard

if TYPE_CHECKING:
    from ctypes import CDLL

    from slipscale.hardware.backends.serial_board.link import Line
    from slipscale.hardware.emulator.emulator import Emulator

TICKS_PER_S = 1000
ROUNDING = 1e-6  # of ticks
SENSOR_S = 0.01  # interval between a sensor's lines


def ticks(duration_s: float) -> int:
    """Return the number of ticks in a duration, rounded up; at least 1 if it is above 0."""
    return max(math.ceil(duration_s * TICKS_PER_S - ROUNDING), int(duration_s > 0))


class VirtualTime(ABC):
    """A clock that runs devices and regular calls while it advances."""

    def __init__(self) -> None:
        self._tick = 0
        self.suspended = 0.0
        self._calls: list[_RegularCall] = []

    def now(self) -> float:
        """Return the virtual time in seconds."""
        return self._tick / TICKS_PER_S

    def suspended_s(self) -> float:
        """Return for how long the computer was suspended."""
        return self.suspended

    def sleep(self, duration_s: float) -> None:
        """Advance the time, and make the regular calls that are due."""
        end = self._tick + ticks(duration_s)
        while self._tick < end:
            self.advance()
            for call in [each for each in self._calls if each.due <= self._tick]:
                if call in self._calls:
                    self._make(call)

    def advance(self) -> None:
        """Advance the time by one tick, as during a read: a driver then makes no other calls."""
        self._tick += 1
        self._run_devices()

    def repeat(self, step: Callable[[], bool], interval_s: float) -> Callable[[], None]:
        """Call a function regularly until it returns False; return a function that ends this."""
        call = _RegularCall(step, ticks(interval_s), self._tick)
        self._calls.append(call)
        return lambda: self._end(call)

    @abstractmethod
    def _run_devices(self) -> None:
        """Advance all devices to the current time."""

    def _make(self, call: _RegularCall) -> None:
        call.due = math.inf  # A call that waits is not made again.
        if call.step():
            call.due = self._tick + call.interval
        else:
            self._end(call)

    def _end(self, call: _RegularCall) -> None:
        if call in self._calls:
            self._calls.remove(call)


class _RegularCall:
    """A function that is called regularly, and the tick at which it is due."""

    def __init__(self, step: Callable[[], bool], interval: int, now: int) -> None:
        self.step = step
        self.interval = interval
        self.due: float = now + interval


class VirtualPort:
    """Port of a `VirtualHost`: the board's end of the line, and the host's."""

    def __init__(self, host: VirtualHost, name: str) -> None:
        self.host = host
        self.name = name
        self.board: Emulator | None = None
        self.line: VirtualLine | None = None  # while a program has opened the port
        self._plugged = False

    def plug_in(self) -> None:
        """Make the port available."""
        self._plugged = True

    def unplug(self) -> None:
        """Remove the port; an open line loses its connection."""
        self._plugged, self.line = False, None

    def send(self, data: bytes) -> None:
        """Send bytes to the program that has opened the port."""
        if self.line is not None:
            self.line.received += data

    def open_line(self) -> VirtualLine:
        """Open the port. Raises `PlateNotFound` or `PlateBusy`."""
        if not self._plugged:
            raise PlateNotFound(f"{self.name}: no such port", level_free=True)
        if self.line is not None:
            raise PlateBusy(f"{self.name}: another program is using this port", level_free=True)
        self.line = VirtualLine(self)
        return self.line


class VirtualLine:
    """Host's end of a line to an emulated board."""

    def __init__(self, port: VirtualPort) -> None:
        self.port = port.name
        self.received = b""
        self._port = port

    def write(self, data: bytes) -> None:
        """Send bytes to the board. Raises `ConnectionLost`."""
        self._board().receive(data)

    def read(self) -> bytes:
        """Return the available bytes, or wait one tick for bytes. Raises `ConnectionLost`."""
        self._board()
        if not self.received:
            self._port.host.advance()
        data, self.received = self.received, b""
        return data

    def close(self) -> None:
        """Close the port."""
        if self._port.line is self:
            self._board().host_left()
            self._port.line = None

    def _board(self) -> Emulator:
        if self._port.line is not self or self._port.board is None:
            raise ConnectionLost(f"{self.port}: the device was disconnected")
        return self._port.board


class VirtualBoard(ControlledBoard):
    """Emulated board at a port of a `VirtualHost`.

    Parameters
    ----------
    port : VirtualPort
        The port.
    *arguments : str
        Arguments of ``slipscale plate emulate``.

    Attributes
    ----------
    host : VirtualHost
        The host, whose time is also the board's.
    """

    def __init__(self, port: VirtualPort, *arguments: str) -> None:
        parser = ArgumentParser()
        emulate.add_arguments(parser)
        parsed = parser.parse_args(arguments)
        self._log = parsed.log.open("x", encoding="utf-8") if parsed.log else None
        self.port, self.host = port.name, port.host
        self.emulator = port.board = emulate.emulated(
            parsed, port, clock=port.host, firmware=_firmware, log=self._log
        )

    def close(self) -> None:
        """Unplug the board, and close its log."""
        self.emulator.unplug()
        if self._log is not None:
            self._log.close()

    def _answer_to(self, line: str) -> dict[str, Any]:
        answer: dict[str, Any] = json.loads(console.answer(self.emulator, line))
        return answer


class VirtualSensor:
    """Sensor that sends lines of numbers, and the port to which it is connected.

    Attributes
    ----------
    port : str
        Name of the port.
    sends : bool
        Whether to send lines.
    """

    def __init__(self, host: VirtualHost, port: str, line: Callable[[float], bytes]) -> None:
        self.port = port
        self.sends = True
        self._host = host
        self._line = line
        self._sent_s = host.now()

    def open_line(self) -> VirtualSensor:
        """Open the port."""
        return self

    def write(self, data: bytes) -> None:
        """Ignore bytes from the host."""

    def read(self) -> bytes:
        """Return the lines sent since the last call."""
        sent = b""
        while self._sent_s + SENSOR_S <= self._host.now():
            self._sent_s += SENSOR_S
            sent += self._line(self._sent_s) if self.sends else b""
        return sent

    def close(self) -> None:
        """Release the port."""


class VirtualHost(VirtualTime):
    """A computer to which emulated boards and sensors can be connected."""

    def __init__(self) -> None:
        super().__init__()
        self._ports: dict[str, VirtualPort | VirtualSensor] = {}
        self._boards: list[VirtualBoard] = []

    def plug_in(self, *arguments: str) -> VirtualBoard:
        """Connect an emulated board; the arguments are those of ``slipscale plate emulate``."""
        port = VirtualPort(self, self._free_name())
        self._ports[port.name] = port
        board = VirtualBoard(port, *arguments)
        self._boards.append(board)
        return board

    def plug_in_sensor(self, line: Callable[[float], bytes]) -> VirtualSensor:
        """Connect a sensor that sends a line 100 times per second, as `EmulatedLine` does."""
        sensor = VirtualSensor(self, self._free_name(), line)
        self._ports[sensor.port] = sensor
        return sensor

    def open_line(self, port: str, *, baud: int = BAUD) -> Line:  # noqa: ARG002 - bytes take no time
        """Open a serial port. Raises `PlateNotFound` or `PlateBusy`."""
        if port not in self._ports:
            raise PlateNotFound(f"{port}: no such port", level_free=True)
        return self._ports[port].open_line()

    def _run_devices(self) -> None:
        for each in self._boards:
            each.emulator.advance()

    def _free_name(self) -> str:
        return f"virtual{len(self._ports)}"


@cache
def _firmware() -> CDLL:
    """Compile the firmware once per process."""
    with TemporaryDirectory(prefix="slipscale-firmware-") as folder:
        return compiled.load(compiled.build(Path(folder)))
