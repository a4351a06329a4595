"""Read laser distance sensors and load cells that send lines of numbers over a serial port.

SPEC for positions: ``lasers:PORT,option=value,...``; for forces: ``load_cells:PORT,...``. Each line
contains one reading: numbers separated by commas, semicolons, tabs or spaces.

=================================  ============================================================
``x``, ``y`` (``normal``,          position of the number in the line, from 1; default 1 and 2.
``lateral``)                       ``y=0``: no second laser; y is reported as 0
``x_scale``, ...                   mm (or N) per unit that the sensor sends (1)
``x_zero``, ...                    the sensor's value at position 0 (without force) (0)
``tare``                           load cells: seconds at the start without a finger on the plate;
                                   their mean becomes the zero (0: none)
``baud``                           baud rate of the port (115200)
=================================  ============================================================

Any microcontroller that prints the readings of its converters is suitable. Each line must contain
all numbers of a reading. Numbers may have decimal commas if another character separates them. Lines
that are invalid or have a different number of fields are skipped and counted in the journal. A
fault is raised if there is no reading for half a second.
"""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Callable
from functools import partial
from statistics import fmean
from typing import ClassVar

from slipscale.faults import UserError
from slipscale.hardware import address as addresses
from slipscale.hardware.backends.serial_board import host as computers
from slipscale.hardware.backends.serial_board.link import Line
from slipscale.hardware.backends.serial_board.serial_line import BAUD
from slipscale.hardware.clock import Clock
from slipscale.hardware.contact.source import (
    FORCE,
    POSITION,
    ContactSource,
    Quantities,
    Sample,
    SensorFault,
    Surroundings,
)
from slipscale.hardware.errors import PlateFault

FIRST_S = 3.0  # some boards restart when their port is opened
SILENT_S = 0.5
AMPLITUDE = ("amplitude_um_pp",)  # quantity of a vibrometer
KEPT = 100_000  # maximum number of samples kept until they are read
SEPARATORS = re.compile(r"[,;\t ]+")
# A comma between digits is a decimal comma if another character separates the numbers.
NUMBER = r"[+-]?\d+(,\d+)?"
DECIMAL_COMMA = re.compile(rf"{NUMBER}([;\t ]+{NUMBER})+")
LONGEST_LINE = 400
TARE_TRIES_S = 0.02


def numbers_of(text: str) -> list[float]:
    """Parse the numbers in a line. Raises ValueError if a number is invalid.

    >>> numbers_of("12,5;3,4"), numbers_of("12.5,3.4"), numbers_of("12,5 3,4")
    ([12.5, 3.4], [12.5, 3.4], [12.5, 3.4])
    """
    if DECIMAL_COMMA.fullmatch(text):
        text = text.replace(",", ".")
    return [float(word) for word in SEPARATORS.split(text)]


class Channel:
    """Column of a sensor's lines, with the scale and zero that convert its numbers to mm or N."""

    def __init__(self, place: int, scale: float, zero: float) -> None:
        self.place, self.scale, self.zero = place, scale, zero

    def value(self, numbers: list[float]) -> float:
        """Return the quantity. Raises IndexError if the line is too short."""
        return (numbers[self.place - 1] - self.zero) * self.scale if self.place else 0.0


class SerialColumns(ContactSource):
    """Sensor on a serial port. A separate thread reads the port.

    Parameters
    ----------
    name : str
        Name in records: ``lasers`` or ``load_cells``.
    port : str
    clock : Clock
        Clock for the readings' time stamps, which are the arrival times of their lines.
    quantities : tuple of str
    channels : sequence of Channel
        Conversion for each quantity.
    tare_s : float
        Initial period over which readings are averaged to obtain the zero, in s.
    baud : int
    """

    name: ClassVar[str] = "serial"

    def __init__(
        self,
        name: str,
        port: str,
        *,
        clock: Clock,
        quantities: Quantities,
        channels: list[Channel],
        tare_s: float = 0.0,
        baud: int = BAUD,
    ) -> None:
        self.kind = name
        self.port = port
        self.quantities = quantities
        self.unreadable = 0  # number of invalid lines
        self._clock = clock
        self._channels = channels
        self._tare_s = tare_s
        self._tared = False
        self._baud = baud
        self._host: computers.Host = computers.SystemHost()
        self._line: Line | None = None
        self._end_reading: Callable[[], None] | None = None
        self._buffer = b""  # the beginning of a line
        self._samples: deque[Sample] = deque(maxlen=KEPT)
        self._fault: PlateFault | None = None
        self._heard_s = 0.0
        self._last_unreadable = ""
        self._fields = 0  # numbers per line; set by the first valid line

    def connect(self) -> None:
        """Open the port, and wait for the first reading.

        If a tare is set, it is measured on the first call.
        """
        self.close()
        self._fault = None
        self._samples.clear()
        self._line = line = self._open()
        self._heard_s = self._clock.now() + FIRST_S - SILENT_S
        self._end_reading = self._host.repeat(partial(self._read, line), 0.0)
        while not self._samples:
            self._check()
            self._clock.sleep(TARE_TRIES_S)
        if self._tare_s and not self._tared:
            self._tare()

    def begin(self) -> None:
        """Discard earlier samples; reconnect the port if it was lost."""
        if self._fault is not None:
            self.connect()
        self._samples.clear()

    def take(self) -> list[Sample]:
        """Return the samples since the last call."""
        self._check()
        return [self._samples.popleft() for _ in range(len(self._samples))]

    def close(self) -> None:
        """Close the port."""
        if self._end_reading is not None:
            self._end_reading()
        if self._line is not None:
            self._line.close()
        self._line = self._end_reading = None

    def describe(self) -> dict[str, object]:
        """Return the sensor's name, port, columns, scales and zeros, as JSON data."""
        return {
            "name": self.kind,
            "port": self.port,
            "channels": {
                quantity: {"number": each.place, "scale": each.scale, "zero": each.zero}
                for quantity, each in zip(self.quantities, self._channels, strict=True)
            },
        }

    def _open(self) -> Line:
        self._buffer = b""
        return self._host.open_line(self.port, baud=self._baud)

    def _check(self) -> None:
        if self._fault is not None:
            raise self._fault
        if self._line is None:
            raise SensorFault("{port}: not connected", port=self.port)
        if self._clock.now() - self._heard_s > SILENT_S:
            last = f"; the last line was '{self._last_unreadable}'" if self._last_unreadable else ""
            self._fault = SensorFault(
                "{port}: {kind} sent no reading{last}", port=self.port, kind=self.kind, last=last
            )
            raise self._fault

    def _tare(self) -> None:
        """Use the mean of readings without a finger on the plate as zero."""
        self._samples.clear()
        end_s = self._clock.now() + self._tare_s
        taken: list[Sample] = []
        while self._clock.now() < end_s or not taken:
            self._clock.sleep(TARE_TRIES_S)
            taken += self.take()
        for number, channel in enumerate(self._channels):
            channel.zero += fmean(each.values[number] for each in taken) / channel.scale
        self._tared = True

    def _read(self, line: Line) -> bool:
        """Read samples. Store a fault, which `take` then raises; return whether to go on."""
        try:
            found = self._readings(line.read())
        except PlateFault as fault:
            self._fault = SensorFault(fault.message)
            return False
        now_s = self._clock.now()
        for values in found:
            self._samples.append(Sample(now_s, values))
            self._heard_s = max(now_s, self._heard_s)
        return True

    def _readings(self, data: bytes) -> list[tuple[float, ...]]:
        """Return the valid readings that end in new bytes, in mm or N; count invalid ones."""
        *lines, rest = (self._buffer + data).split(b"\n")
        self._buffer = rest[-LONGEST_LINE:]
        found = (self._values(each) for each in lines)
        return [values for values in found if values is not None]

    def _values(self, line: bytes) -> tuple[float, ...] | None:
        """Return the readings in a line, in mm or N. Invalid lines are counted and return None."""
        text = line.decode("ascii", "replace").strip()
        try:
            numbers = numbers_of(text)
            values = tuple(channel.value(numbers) for channel in self._channels)
        except (ValueError, IndexError):
            numbers, values = [], (math.nan,)
        fields = self._fields or len(numbers)
        if all(math.isfinite(value) for value in values) and len(numbers) == fields:
            self._fields = fields
            return values
        self.unreadable += 1
        self._last_unreadable = text[:60]
        return None


def _place(text: str) -> int:
    value = addresses.number(text)
    if value != int(value) or not 0 <= value <= 99:  # noqa: PLR2004 - nobody sends more
        raise ValueError("expected the number's position in the line, counted from 1")
    return int(value)


def _baud(text: str) -> int:
    value = int(addresses.positive_number(text))
    if value > 4_000_000:  # noqa: PLR2004 - no port is faster
        raise ValueError("expected at most 4000000")
    return value


def _scale(text: str) -> float:
    value = addresses.number(text)
    if value == 0:
        raise ValueError("expected a number other than 0")
    return value


def seconds(text: str) -> float:
    """Return the duration of a tare in s. Raises ValueError if it is not from 0 to 60 s."""
    value = addresses.number(text)
    if not 0 <= value <= 60:  # noqa: PLR2004 - nobody waits longer
        raise ValueError("expected 0 to 60 seconds")
    return value


def _options(names: tuple[str, ...]) -> dict[str, Callable[[str], object]]:
    each: dict[str, Callable[[str], object]] = {"baud": _baud, "tare": seconds}
    for name in names:
        each |= {name: _place, f"{name}_scale": _scale, f"{name}_zero": addresses.number}
    return each


def _source(
    name: str, address: str, surroundings: Surroundings, *, what: str, names: tuple[str, ...],
    quantities: Quantities,
) -> ContactSource:  # fmt: skip
    port, options = addresses.split_address(address, _options(names), what=f"{what} {name}")
    if not port:
        raise UserError(
            "{what} '{name}': expected {name}:PORT; slipscale plate list shows the ports",
            what=what,
            name=name,
        )
    channels = [
        Channel(
            options.get(each, number),
            options.get(f"{each}_scale", 1.0),
            options.get(f"{each}_zero", 0.0),
        )
        for number, each in enumerate(names, start=1)
    ]
    if not all(channel.place for channel in channels[: 1 if what == "--position" else None]):
        raise UserError(
            "{what} '{name}:{address}': expected the position of {names} in the line, counted "
            "from 1",
            what=what,
            name=name,
            address=address,
            names=names[0],
        )
    return SerialColumns(
        name,
        port,
        clock=surroundings.clock,
        quantities=quantities,
        channels=channels,
        tare_s=options.get("tare", 0.0),
        baud=options.get("baud", BAUD),
    )


def open_vibrometer(spec: str, clock: Clock) -> ContactSource:
    """Return an amplitude sensor for the SPEC ``vibrometer:PORT,amplitude_scale=...``.

    Raises
    ------
    UserError
        If the SPEC is invalid or contains an unknown option.
    """
    name, _, address = spec.partition(":")
    if name != "vibrometer":
        raise UserError("track_resonance '{spec}': expected vibrometer:PORT", spec=spec)
    return _source(
        name, address, Surroundings(clock=clock), what="track_resonance", names=("amplitude",),
        quantities=AMPLITUDE,
    )  # fmt: skip


def open_lasers(address: str, surroundings: Surroundings) -> ContactSource:
    """Return a source with two laser sensors (entry point ``lasers``). Raises `UserError`."""
    return _source(
        "lasers", address, surroundings, what="--position", names=("x", "y"), quantities=POSITION
    )


def open_load_cells(address: str, surroundings: Surroundings) -> ContactSource:
    """Return a source with two load cells (entry point ``load_cells``). Raises `UserError`."""
    return _source(
        "load_cells", address, surroundings, what="--force", names=("normal", "lateral"),
        quantities=FORCE,
    )  # fmt: skip
