"""Implement the driver board's protocol (docs/reference/board-protocol.md).

The serial backend and the emulated board both use this module.
"""

from __future__ import annotations

import math
import re
from binascii import crc_hqx
from dataclasses import dataclass
from typing import Final

from slipscale.faults.message import Message
from slipscale.stimuli.modulation import Loop

PROTOCOL: Final = "slipscale-plate-1"  # the model field of *IDN?
UNIT: Final = "um_pp"  # unit of amplitudes if the board does not answer UNIT?
STOP: Final = b"!"  # byte that silences the plate immediately, valid anywhere
LONGEST_LINE: Final = 96  # maximum line length in bytes, without the line feed
LAST_SEQUENCE: Final = 65_535
WATCHDOG_MS: Final = (400, 2_000)  # allowed range; the shortest time covers three lost commands
RESOLUTION: Final = 1e-4  # of the amplitudes that a board reports, in its unit
POINTS_A_LINE: Final = 8  # amplitudes that fit in one LIST:AMPL line even with the most digits

VIBRATING: Final = ("RAMP", "HOLD", "SAT", "LIST", "OPEN")  # states in which the output is on

# SCPI defines the negative error codes; positive codes are specific to the device.
OK: Final = 0
DATA_TYPE, MISSING_PARAMETER, UNDEFINED_HEADER = -104, -109, -113
SETTINGS_CONFLICT, OUT_OF_RANGE = -221, -222
TOO_HOT, BUSY = 101, 102

MEANINGS: Final = {
    OK: "No error",
    DATA_TYPE: "Data type error",
    MISSING_PARAMETER: "Missing parameter",
    UNDEFINED_HEADER: "Undefined header",
    SETTINGS_CONFLICT: "Settings conflict",
    OUT_OF_RANGE: "Data out of range",
    TOO_HOT: "Over temperature",
    BUSY: "Busy",
}

COMMAND = re.compile(rb">([1-9]\d{0,4}) ([ \x22-;=?-~]+)\*([0-9A-F]{4})")
REPLY = re.compile(rb"<([1-9]\d{0,4}) ([0-9A-F]{8}) (-?\d{1,4}) ([ -~]*)\*([0-9A-F]{4})")


class ImpossibleValue(ValueError):
    """Raised if a board reports an impossible value."""


@dataclass(frozen=True, slots=True)
class BoardReply:
    """Board's reply to the command with the same sequence number."""

    sequence: int
    boot: str
    code: int
    value: str


@dataclass(frozen=True, slots=True, kw_only=True)
class BoardStatus:
    """Status of the board, from the answer to ``STAT?``.

    ``state`` is OFF, RAMP (ramping or not settled), HOLD (settled), LIST (playing a list; target
    and amplitude are means over its period, and the voltage is the maximum), SAT (insufficient
    voltage), OPEN (open loop), or the reason why the plate was silenced: WDOG, HOT or LONG.
    ``level`` and ``temperature_c`` are None if the board has no sensor. Levels are in the unit that
    ``UNIT?`` reports.
    """

    state: str
    target_level: float
    level: float | None
    frequency_hz: float
    voltage_v: float
    temperature_c: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class BoardLimits:
    """Limits and watchdog time of the board, from the answer to ``LIM?``."""

    level: float = 2.5
    voltage_v: float = 16.5
    frequency_min_hz: float = 25_000.0
    frequency_max_hz: float = 40_000.0
    watchdog_ms: float = 500.0
    on_time_s: float = 600.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ListLimits:
    """Maximum length, shortest step and shortest edge of a list, from ``LIST:LIM?``."""

    points: int = 64
    step_ms: float = 4.0
    edge_ms: float = 2.0


def crc16(data: bytes) -> int:
    """Return the CRC-16/CCITT-FALSE of data (polynomial 0x1021, start 0xFFFF).

    >>> f"{crc16(b'123456789'):04X}"
    '29B1'
    """
    return crc_hqx(data, 0xFFFF)


def command_frame(sequence: int, body: str) -> bytes:
    """Encode a command for the serial line.

    >>> command_frame(7, "STAT?").decode().rstrip()
    '>7 STAT?*EF7F'
    """
    payload = f"{sequence} {body}".encode("ascii")
    return b">%b*%04X\n" % (payload, crc16(payload))


def reply_frame(reply: BoardReply) -> bytes:
    """Encode a reply for the serial line."""
    payload = f"{reply.sequence} {reply.boot} {reply.code} {reply.value}".encode("ascii")
    return b"<%b*%04X\n" % (payload, crc16(payload))


def parse_command(line: bytes) -> tuple[int, str] | None:
    """Parse a command; return its sequence number and body, or None if the line is invalid."""
    match = _checked(COMMAND, line, b">")
    if not match or int(match[1]) > LAST_SEQUENCE:
        return None
    return int(match[1]), match[2].decode("ascii")


def parse_reply(line: bytes) -> BoardReply | None:
    """Parse a reply, ignoring text before its ``<``; return None if the line is invalid."""
    match = _checked(REPLY, line, b"<")
    if not match:
        return None
    return BoardReply(int(match[1]), match[2].decode(), int(match[3]), match[4].decode())


def _checked(pattern: re.Pattern[bytes], line: bytes, start: bytes) -> re.Match[bytes] | None:
    frame = line[max(line.rfind(start), 0) :].rstrip(b"\r")
    match = pattern.fullmatch(frame)
    if match and crc16(frame[1:-5]) == int(match[match.re.groups], 16):
        return match
    return None


def format_status(status: BoardStatus) -> str:
    """Format the value of a reply to ``STAT?``."""
    amplitude = "" if status.level is None else f"{status.level:.4f}"
    temperature = "" if status.temperature_c is None else f"{status.temperature_c:.1f}"
    return (
        f"{status.state},{status.target_level:.4f},{amplitude},"
        f"{status.frequency_hz:.1f},{status.voltage_v:.3f},{temperature}"
    )


def parse_status(value: str) -> BoardStatus:
    """Parse the value of a reply to ``STAT?``; raise ValueError if it is invalid."""
    state, target, amplitude, frequency, voltage, temperature = value.split(",")
    return BoardStatus(
        state=state,
        target_level=_finite(target),
        level=_finite(amplitude) if amplitude else None,
        frequency_hz=_finite(frequency),
        voltage_v=_finite(voltage),
        temperature_c=_finite(temperature) if temperature else None,
    )


def format_limits(limits: BoardLimits) -> str:
    """Format the value of a reply to ``LIM?``."""
    return (
        f"{limits.level:.4f},{limits.voltage_v:.3f},{limits.frequency_min_hz:.1f},"
        f"{limits.frequency_max_hz:.1f},{limits.watchdog_ms:.0f},{limits.on_time_s:.0f}"
    )


def parse_limits(value: str) -> BoardLimits:
    """Parse the value of a reply to ``LIM?``.

    Raises
    ------
    ImpossibleValue
        If a limit is outside the range allowed for boards.
    ValueError
        If the value is not a reply to ``LIM?``.
    """
    amplitude, voltage, lowest, highest, watchdog, on_time = map(_finite, value.split(","))
    shortest_ms, longest_ms = WATCHDOG_MS
    _require(amplitude > 0, f"the largest amplitude is {amplitude:g}, but must be above 0")
    _require(voltage > 0, f"the largest voltage is {voltage:g} V, but must be above 0")
    _require(
        0 < lowest < highest,
        f"the band is {lowest:g} to {highest:g} Hz, but must be two increasing frequencies above 0",
    )
    _require(
        shortest_ms <= watchdog <= longest_ms,
        f"the watchdog time is {watchdog:g} ms, but must be {shortest_ms} to {longest_ms} ms",
    )
    _require(on_time >= 1, f"the longest on-time is {on_time:g} s, but must be at least 1 s")
    return BoardLimits(
        level=amplitude,
        voltage_v=voltage,
        frequency_min_hz=lowest,
        frequency_max_hz=highest,
        watchdog_ms=watchdog,
        on_time_s=on_time,
    )


def format_list_limits(limits: ListLimits) -> str:
    """Format the value of a reply to ``LIST:LIM?``."""
    return f"{limits.points},{limits.step_ms:.3f},{limits.edge_ms:.3f}"


def parse_list_limits(value: str) -> ListLimits:
    """Parse the value of a reply to ``LIST:LIM?``.

    Raises
    ------
    ImpossibleValue
        If a limit is outside the range allowed for boards.
    ValueError
        If the value is not a reply to ``LIST:LIM?``.
    """
    points, step, edge = value.split(",")
    limits = ListLimits(points=int(points), step_ms=_finite(step), edge_ms=_finite(edge))
    _require(
        limits.points > 1,
        f"the largest number of amplitudes is {limits.points}, but must be at least 2",
    )
    _require(
        limits.step_ms > 0,
        f"the shortest time per amplitude is {limits.step_ms:g} ms, but must be above 0",
    )
    _require(limits.edge_ms > 0, f"the shortest edge is {limits.edge_ms:g} ms, but must be above 0")
    return limits


def _finite(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(Message("'{text}' is not a number", text=text))
    return number


def _require(condition: bool, otherwise: str) -> None:
    if not condition:
        raise ImpossibleValue(otherwise)


def amplitude_command(level: float) -> str:
    """Return the command that ramps to a level, with all six decimals of the protocol.

    >>> amplitude_command(0.0346787)
    'AMPL 0.034679'
    """
    return f"AMPL {level:.6f}"


def list_commands(loop: Loop) -> list[str]:
    """Return the commands that play a loop; the plate must have settled before.

    >>> from slipscale.stimuli.modulation import Loop
    >>> list_commands(Loop(levels=(2, 0.4), step_s=0.025, edge_s=0.002, mean_level=1.2))
    ['LIST:AMPL 1,2.0000,0.4000', 'LIST:PLAY 2,25.000,2.000']
    """
    amplitudes = [f"{each:.4f}" for each in loop.levels]
    lines = [
        f"LIST:AMPL {first + 1},{','.join(amplitudes[first : first + POINTS_A_LINE])}"
        for first in range(0, len(amplitudes), POINTS_A_LINE)
    ]
    times = f"{1000 * loop.step_s:.3f},{1000 * loop.edge_s:.3f}"
    return [*lines, f"LIST:PLAY {len(amplitudes)},{times}"]
