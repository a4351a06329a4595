"""Implement the driver board's firmware in Python, for `slipscale plate emulate`.

The code performs no I/O: it receives bytes and the time, returns bytes, and drives a simulated
plate. The reference firmware (hardware/firmware) implements the same behaviour in C++. Both
implementations are tested against docs/reference/board-transcript.txt.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from statistics import fmean

from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.backends.serial_board.protocol import (
    BoardLimits,
    BoardReply,
    BoardStatus,
    ListLimits,
)
from slipscale.hardware.emulator import arguments as parse
from slipscale.hardware.emulator.arguments import Refusal
from slipscale.hardware.plate.twin import OFF, Drive, Twin
from slipscale.stimuli.modulation import Loop, along_edge

RAMP_S = 0.025
RAMP_DOWN_S = 0.015  # delay from a ramp to 0 until the output is switched off
CORRECT_S = 0.010
FOLLOW_S = 0.005  # time after a change of the voltage during which readings are ignored
LARGEST_CORRECTION = 0.05  # largest change of voltage per step, to avoid clicks
# Largest factor by which the calibrated volts per µm are corrected. A finger that reduces Q from 60
# to 50 requires a factor of 1.2. Without this limit, a broken sensor would cause the maximum
# voltage.
GAIN_BAND = 1.5
# The plate has settled when `MEANS_SETTLED` consecutive mean readings differ from the target by at
# most `BAND` times the target or, if larger, `BAND_OF_LARGEST` times the largest level.
BAND = 0.025
BAND_OF_LARGEST = 0.01  # 0.025 µm p-p
MEANS_SETTLED = 2
ROUNDING_S = 1e-9  # tolerance of time differences
HOTTEST_C = 60.0
ERROR_QUEUE = 8
IDENTITY = f"Slipscale,{wire.PROTOCOL},EMULATED-1,1.2"
OLD_IDENTITY = f"Slipscale,{wire.PROTOCOL},EMULATED-1,1.0"  # version without lists


class Board:
    """Emulated driver board, which keeps a plate at resonance.

    Parameters
    ----------
    twin : Twin
        Simulated plate.
    boot : int
        Boot number, which changes at every start.
    limits : BoardLimits
        Limits that the board enforces, in addition to the host's limits.
    identity : str
        Answer to ``*IDN?``.
    lists : bool
        Whether the firmware supports lists of amplitudes.
    unit : str
        Answer to ``UNIT?``: the unit of amplitudes, written as in the names of data columns.
    """

    def __init__(
        self,
        twin: Twin,
        *,
        boot: int,
        limits: BoardLimits | None = None,
        identity: str = IDENTITY,
        lists: bool = True,
        unit: str = wire.UNIT,
    ) -> None:
        self.twin = twin
        self.boot = f"{boot & 0xFFFF_FFFF:08X}"
        self.limits = limits or BoardLimits()
        self.identity = identity
        self.unit = unit
        # In other units, only the dynamics are simulated, as in the mock backend.
        same = unit == wire.UNIT
        self.um_pp_per_level = 1.0 if same else BoardLimits().level / self.limits.level
        self.lists = ListLimits()
        self._commands = (
            COMMANDS
            if lists
            else {
                header: each for header, each in COMMANDS.items() if not header.startswith("LIST:")
            }
        )
        self.state = "OFF"
        self.busy = False
        self.hot = False
        self.target_level = 0.0
        self.points: list[float] = []
        self.played: Loop | None = None
        self._from_level = 0.0
        self._now_level = 0.0  # current amplitude on the ramp
        self._frequency_hz: float | None = None  # None: follow the resonance
        self._heard_s = 0.0
        self._commanded_s = 0.0
        self._arrived = False  # The end of the ramp has reached the plate.
        self._nominal_volts_per_level = (
            self.um_pp_per_level / twin.resonator.gain_um_pp_per_v  # as calibrated
        )
        self._volts_per_level = self._nominal_volts_per_level  # for the current load
        self._limited = False  # The voltage is at its limit.
        self._corrected_s = 0.0
        self._readings: list[float] = []  # since the last correction
        self._means_inside = 0
        self._periods = 0  # completed periods of the amplitude list
        self._buffer = b""
        self._last: tuple[tuple[int, str], bytes] | None = None
        self._errors: deque[int] = deque(maxlen=ERROR_QUEUE)

    @property
    def vibrates(self) -> bool:
        """Whether the output is on."""
        return self.state in wire.VIBRATING

    def receive(self, data: bytes, now_s: float) -> list[tuple[str, bytes]]:
        """Process received bytes; return (command, reply) for each complete command."""
        answers = []
        for byte in data:
            if byte == wire.STOP[0]:
                self.silence(now_s)
                self._buffer = b""  # Bytes received before the stop byte are discarded.
            elif byte == ord("\n"):
                line, self._buffer = self._buffer, b""
                if len(line) <= wire.LONGEST_LINE and (answer := self._line(line, now_s)):
                    answers.append(answer)
            elif len(self._buffer) <= wire.LONGEST_LINE:
                self._buffer += bytes([byte])
        return answers

    def tick(self, now_s: float) -> None:
        """Advance the board to the given time."""
        if not self.vibrates:
            return
        if now_s - self._heard_s > self.limits.watchdog_ms / 1000:
            self.silence(now_s, "WDOG")
        elif now_s - self._commanded_s > self.limits.on_time_s:
            self.silence(now_s, "LONG")
        elif self.temperature_c(now_s) > HOTTEST_C:
            self.silence(now_s, "HOT")
        elif self.state == "RAMP" and not self._arrived:
            self._ramp(now_s)
        elif self.played:
            self._play(self.played, now_s)
        elif self.state != "OPEN":
            self._hold(now_s)

    def silence(self, now_s: float, state: str = "OFF") -> None:
        """Switch the output off."""
        self.twin.set_drive(OFF, now_s)
        self.state, self.target_level, self._now_level, self.played = state, 0.0, 0.0, None
        self._volts_per_level, self._limited = self._nominal_volts_per_level, False

    def commanded_level(self, now_s: float) -> float:
        """Return the amplitude that the board commands at a given time."""
        if self.played:
            return self.played.at_level(now_s - self._commanded_s)
        return self._now_level

    def _measured(self, now_s: float) -> float:
        return self.twin.measure_um_pp(now_s) / self.um_pp_per_level

    def temperature_c(self, now_s: float) -> float:
        """Return the temperature sensor's reading."""
        return HOTTEST_C + 15 if self.hot else self.twin.temperature_c(now_s)

    def status(self, now_s: float) -> BoardStatus:
        """Return the answer to ``STAT?``."""
        frequency_hz = self._frequency_hz or self.twin.conditions(now_s).resonance_hz
        return BoardStatus(
            state=self.state,
            target_level=self.target_level,
            level=self._measured(now_s),
            frequency_hz=frequency_hz,
            voltage_v=self.twin.voltage_v(now_s),
            temperature_c=self.temperature_c(now_s),
        )

    def _line(self, line: bytes, now_s: float) -> tuple[str, bytes] | None:
        if line.rstrip(b"\r") == b"*IDN?":  # without a frame, for use in a terminal
            return "*IDN?", self.identity.encode("ascii") + b"\r\n"
        command = wire.parse_command(line)
        if command is None:
            return None  # No answer: the host repeats the command after a time-out.
        if self._last and self._last[0] == command:
            self._heard_s = now_s
            return command[1], self._last[1]  # A repeated command is not executed again.
        reply = wire.reply_frame(self._answer(*command, now_s))
        if not self.busy:
            self._last = (command, reply)
        return command[1], reply

    def _answer(self, sequence: int, body: str, now_s: float) -> BoardReply:
        try:
            return BoardReply(sequence, self.boot, wire.OK, self._run(body, now_s))
        except Refusal as refusal:
            self._errors.append(refusal.code)
            return BoardReply(sequence, self.boot, refusal.code, str(refusal))

    def _run(self, body: str, now_s: float) -> str:
        if self.busy:
            raise Refusal(wire.BUSY)
        self._heard_s = now_s
        self.tick(now_s)
        header, _, arguments = body.partition(" ")
        if header not in self._commands:
            raise Refusal(wire.UNDEFINED_HEADER)
        fewest, most, run = self._commands[header]
        return run(self, parse.split(arguments, fewest, most), now_s)

    def _reset(self, _: list[str], now_s: float) -> str:
        self.silence(now_s)
        self._errors.clear()
        self.points.clear()
        return ""

    def _error(self, _: list[str], __: float) -> str:
        code = self._errors.popleft() if self._errors else wire.OK
        return f'{code},"{wire.MEANINGS[code]}"'

    def _amplitude(self, arguments: list[str], now_s: float) -> str:
        level = parse.within(arguments[0], 0, self.limits.level)
        self._require_cool(now_s)
        self._from_level = self._now_level = self.commanded_level(now_s)
        self.target_level, self.played = level, None
        self._frequency_hz, self._commanded_s, self._arrived = None, now_s, False
        self._means_inside = 0
        if level == self._from_level == 0:
            self.silence(now_s)
        else:
            self.state = "RAMP"
        return ""

    def _open_loop(self, arguments: list[str], now_s: float) -> str:
        limits = self.limits
        frequency_hz = parse.within(arguments[0], limits.frequency_min_hz, limits.frequency_max_hz)
        voltage_v = parse.within(arguments[1], 0, limits.voltage_v)
        self._require_cool(now_s)
        self.state, self.target_level, self._now_level, self.played = "OPEN", 0.0, 0.0, None
        self._frequency_hz, self._commanded_s = frequency_hz, now_s
        self.twin.set_drive(Drive(frequency_hz=frequency_hz, voltage_v=voltage_v), now_s)
        return ""

    def _output(self, arguments: list[str], now_s: float) -> str:
        if arguments[0] not in ("OFF", "0"):
            raise Refusal(wire.OUT_OF_RANGE)
        self.silence(now_s)
        return ""

    def _list_amplitudes(self, arguments: list[str], _: float) -> str:
        first, *texts = arguments
        kept = parse.whole(first, 1, len(self.points) + 1) - 1
        points = [parse.within(text, 0, self.limits.level) for text in texts]
        if kept + len(points) > self.lists.points:
            raise Refusal(wire.OUT_OF_RANGE)
        if self.played:
            raise Refusal(wire.SETTINGS_CONFLICT)
        self.points[kept:] = points
        return ""

    def _list_play(self, arguments: list[str], now_s: float) -> str:
        count = parse.whole(arguments[0], 2, self.lists.points)
        step_ms = parse.within(arguments[1], self.lists.step_ms, 1000 * self.limits.on_time_s)
        edge_ms = parse.within(arguments[2], self.lists.edge_ms, step_ms)
        self._require_cool(now_s)
        if self.state != "HOLD" or count != len(self.points):
            raise Refusal(wire.SETTINGS_CONFLICT)
        self.played = Loop(
            levels=tuple(self.points),
            step_s=step_ms / 1000,
            edge_s=edge_ms / 1000,
            mean_level=self.target_level,
        )
        self.state, self.target_level = "LIST", fmean(self.points)
        self._commanded_s, self._periods = now_s, 0
        self._apply(now_s)
        return ""

    def _require_cool(self, now_s: float) -> None:
        if self.temperature_c(now_s) > HOTTEST_C:
            self.silence(now_s, "HOT")
            raise Refusal(wire.TOO_HOT)

    def _ramp(self, now_s: float) -> None:
        """Advance the ramp, and record whether it is complete."""
        part = min((now_s - self._commanded_s + ROUNDING_S) / RAMP_S, 1)
        self._now_level = along_edge(self._from_level, self.target_level, part)
        self._apply(now_s)
        self._arrived = part == 1
        self._begin_mean(now_s)

    def _begin_mean(self, now_s: float) -> None:
        self._corrected_s = now_s
        self._readings.clear()

    def _hold(self, now_s: float) -> None:
        """Correct the voltage, based on the mean reading since the last correction took effect."""
        elapsed_s = now_s - self._corrected_s + ROUNDING_S
        if self.target_level == 0:
            if elapsed_s >= RAMP_DOWN_S:
                self.silence(now_s)
            return
        if elapsed_s <= FOLLOW_S + 2 * ROUNDING_S:
            return
        self._readings.append(self._measured(now_s))
        if elapsed_s < CORRECT_S:
            return
        measured_level, was_limited = fmean(self._readings), self._limited
        self._limited = not self._correct(measured_level, self.target_level)
        self._apply(now_s)
        self._begin_mean(now_s)
        self.state = self._settled(measured_level, was_limited=was_limited)

    def _settled(self, measured_level: float, *, was_limited: bool) -> str:
        """Return the state: HOLD after enough readings within the tolerance, else SAT or RAMP."""
        short_by = self.target_level - measured_level
        if abs(short_by) > max(BAND * self.target_level, BAND_OF_LARGEST * self.limits.level):
            self._means_inside = 0
            return "SAT" if was_limited and short_by > 0 else "RAMP"
        self._means_inside += 1
        return "HOLD" if self._means_inside >= MEANS_SETTLED else "RAMP"

    def _play(self, played: Loop, now_s: float) -> None:
        """Correct the voltage after each period except the first, based on the period's mean."""
        periods = int((now_s - self._commanded_s + ROUNDING_S) / played.period_s)
        if periods > max(self._periods, 1):
            largest_level = max(played.levels)
            enough = self._correct(self._measured(now_s), largest_level)
            self.state = "LIST" if enough else "SAT"
            self._apply(now_s)
        self._periods = periods

    def _correct(self, measured_level: float, largest_level: float) -> bool:
        """Correct the voltage, and return whether it is sufficient for the largest amplitude."""
        if largest_level <= 0:
            return True
        factor = self.target_level / measured_level if measured_level > 0 else math.inf
        factor = min(max(factor, 1 - LARGEST_CORRECTION), 1 + LARGEST_CORRECTION)
        nominal = self._nominal_volts_per_level
        most = min(self.twin.voltage_limit_v / largest_level, GAIN_BAND * nominal)
        self._volts_per_level = min(max(self._volts_per_level * factor, nominal / GAIN_BAND), most)
        return self._volts_per_level < most

    def _apply(self, now_s: float) -> None:
        scale, played = self.um_pp_per_level, self.played
        drive = Drive(
            target_um_pp=scale * (self.target_level if played else self._now_level),
            volts_per_um=self._volts_per_level / scale,
            played=played
            and replace(
                played,
                levels=tuple(scale * each for each in played.levels),
                mean_level=scale * played.mean_level,
            ),
            since_s=self._commanded_s if self.played else None,
        )
        self.twin.set_drive(drive, now_s)


# Minimum and maximum number of arguments, and action, keyed by header.
COMMANDS: dict[str, tuple[int, int, Callable[[Board, list[str], float], str]]] = {
    "*IDN?": (0, 0, lambda board, _, __: board.identity),
    "*RST": (0, 0, Board._reset),  # noqa: SLF001 - the table belongs to the class
    "SYST:ERR?": (0, 0, Board._error),  # noqa: SLF001
    "UNIT?": (0, 0, lambda board, _, __: board.unit),
    "LIM?": (0, 0, lambda board, _, __: wire.format_limits(board.limits)),
    "AMPL": (1, 1, Board._amplitude),  # noqa: SLF001
    "DRIV": (2, 2, Board._open_loop),  # noqa: SLF001
    "OUTP": (1, 1, Board._output),  # noqa: SLF001
    "LIST:LIM?": (0, 0, lambda board, _, __: wire.format_list_limits(board.lists)),
    "LIST:AMPL": (2, 1 + wire.POINTS_A_LINE, Board._list_amplitudes),  # noqa: SLF001
    "LIST:PLAY": (3, 3, Board._list_play),  # noqa: SLF001
    "STAT?": (0, 0, lambda board, _, now_s: wire.format_status(board.status(now_s))),
}
