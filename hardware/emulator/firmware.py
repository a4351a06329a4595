"""The driver board's firmware in Python: what `slipscale plate emulate` runs.

Pure: bytes and the time go in, bytes come out; the plate behind it is the twin. The reference
firmware (hardware/firmware) does the same in C++, and both are tested against the transcript in
docs/board-protocol.md.
"""

from __future__ import annotations

from collections import deque
from statistics import fmean
from typing import TYPE_CHECKING

from hardware.backends.serial_board import protocol as wire
from hardware.backends.serial_board.protocol import BoardLimits, ListLimits, Reply, Status
from hardware.emulator import arguments as parse
from hardware.emulator.arguments import Refusal
from hardware.plate.twin import OFF, Drive
from stimuli.modulation import Loop, along_edge

if TYPE_CHECKING:
    from collections.abc import Callable

    from hardware.plate.twin import Twin

RAMP_S = 0.025
SETTLE_S = 0.015
HOTTEST_C = 60.0
ERROR_QUEUE = 8
IDENTITY = f"Slipscale,{wire.PROTOCOL},EMULATED-1,1.1"
OLD_IDENTITY = f"Slipscale,{wire.PROTOCOL},EMULATED-1,1.0"  # knew no lists


class Board:
    """A driver board that holds a plate at resonance.

    Parameters
    ----------
    twin : Twin
        The plate.
    boot : int
        Differs from one start to the next.
    limits : BoardLimits
        Enforced on the board, whatever the host believes.
    identity : str
        The value of ``*IDN?``.
    lists : bool
        Whether its firmware knows lists of amplitudes.
    """

    def __init__(
        self,
        twin: Twin,
        *,
        boot: int,
        limits: BoardLimits | None = None,
        identity: str = IDENTITY,
        lists: bool = True,
    ) -> None:
        self.twin = twin
        self.boot = f"{boot & 0xFFFF_FFFF:08X}"
        self.limits = limits or BoardLimits()
        self.identity = identity
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
        self.target_um_pp = 0.0
        self.points_um_pp: list[float] = []
        self.played: Loop | None = None
        self._from_um_pp = 0.0
        self._now_um_pp = 0.0  # what the ramp has put on the plate
        self._frequency_hz: float | None = None  # None follows the resonance
        self._heard_s = 0.0
        self._commanded_s = 0.0
        self._arrived_s: float | None = None  # when the end of the ramp was put on the plate
        self._buffer = b""
        self._last: tuple[tuple[int, str], bytes] | None = None
        self._errors: deque[int] = deque(maxlen=ERROR_QUEUE)

    @property
    def vibrates(self) -> bool:
        """Whether the output is on."""
        return self.state in ("RAMP", "HOLD", "SAT", "LIST", "OPEN")

    def receive(self, data: bytes, now_s: float) -> list[tuple[str, bytes]]:
        """Take bytes from the line; return (command, reply) for each that was complete."""
        answers = []
        for byte in data:
            if byte == wire.STOP[0]:
                self.silence(now_s)
            elif byte == ord("\n"):
                line, self._buffer = self._buffer, b""
                if answer := self._line(line, now_s):
                    answers.append(answer)
            elif len(self._buffer) < wire.LONGEST_FRAME:
                self._buffer += bytes([byte])
        return answers

    def tick(self, now_s: float) -> None:
        """Let time pass: ramp, settle, watchdog, longest on-time, temperature."""
        if not self.vibrates:
            return
        if now_s - self._heard_s > self.limits.watchdog_ms / 1000:
            self.silence(now_s, "WDOG")
        elif now_s - self._commanded_s > self.limits.on_time_s:
            self.silence(now_s, "LONG")
        elif self.temperature_c(now_s) > HOTTEST_C:
            self.silence(now_s, "HOT")
        elif self.state == "RAMP":
            self._ramp(now_s)
        elif self.state != "OPEN":
            self._note_saturation(now_s)

    def silence(self, now_s: float, state: str = "OFF") -> None:
        """Switch the output off."""
        self.twin.set_drive(OFF, now_s)
        self.state, self.target_um_pp, self._now_um_pp, self.played = state, 0.0, 0.0, None

    def commanded_um_pp(self, now_s: float) -> float:
        """Return the amplitude that is due now."""
        if self.played:
            return self.played.at_um_pp(now_s - self._commanded_s)
        return self._now_um_pp

    def temperature_c(self, now_s: float) -> float:
        """Return what the board's sensor says."""
        return HOTTEST_C + 15 if self.hot else self.twin.temperature_c(now_s)

    def status(self, now_s: float) -> Status:
        """Return what ``STAT?`` tells."""
        frequency_hz = self._frequency_hz or self.twin.conditions(now_s).resonance_hz
        return Status(
            state=self.state,
            target_um_pp=self.target_um_pp,
            amplitude_um_pp=self.twin.measure_um_pp(now_s),
            frequency_hz=frequency_hz,
            voltage_v=self.twin.voltage_v(now_s),
            temperature_c=self.temperature_c(now_s),
        )

    def _line(self, line: bytes, now_s: float) -> tuple[str, bytes] | None:
        if line.rstrip(b"\r") == b"*IDN?":  # plain, for whoever looks with a terminal
            return "*IDN?", self.identity.encode("ascii") + b"\r\n"
        command = wire.parse_command(line)
        if command is None:
            return None  # no answer: the host's time-out and its repetition mend it
        if self._last and self._last[0] == command:
            self._heard_s = now_s
            return command[1], self._last[1]  # a repetition: it ran before
        reply = wire.reply_frame(self._answer(*command, now_s))
        if not self.busy:
            self._last = (command, reply)
        return command[1], reply

    def _answer(self, sequence: int, body: str, now_s: float) -> Reply:
        try:
            return Reply(sequence, self.boot, wire.OK, self._run(body, now_s))
        except Refusal as refusal:
            self._errors.append(refusal.code)
            return Reply(sequence, self.boot, refusal.code, str(refusal))

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
        self.points_um_pp.clear()
        return ""

    def _error(self, _: list[str], __: float) -> str:
        code = self._errors.popleft() if self._errors else wire.OK
        return f'{code},"{wire.MEANINGS[code]}"'

    def _amplitude(self, arguments: list[str], now_s: float) -> str:
        amplitude_um_pp = parse.within(arguments[0], 0, self.limits.amplitude_um_pp)
        self._require_cool(now_s)
        self._from_um_pp = self._now_um_pp = self.commanded_um_pp(now_s)
        self.target_um_pp, self.played = amplitude_um_pp, None
        self._frequency_hz, self._commanded_s, self._arrived_s = None, now_s, None
        if amplitude_um_pp == self._from_um_pp == 0:
            self.silence(now_s)
        else:
            self.state = "RAMP"
        return ""

    def _open_loop(self, arguments: list[str], now_s: float) -> str:
        limits = self.limits
        frequency_hz = parse.within(arguments[0], limits.frequency_min_hz, limits.frequency_max_hz)
        voltage_v = parse.within(arguments[1], 0, limits.voltage_v)
        self._require_cool(now_s)
        self.state, self.target_um_pp, self._now_um_pp, self.played = "OPEN", 0.0, 0.0, None
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
        kept = parse.whole(first, 1, len(self.points_um_pp) + 1) - 1
        points_um_pp = [parse.within(text, 0, self.limits.amplitude_um_pp) for text in texts]
        if kept + len(points_um_pp) > self.lists.points:
            raise Refusal(wire.OUT_OF_RANGE)
        if self.played:
            raise Refusal(wire.SETTINGS_CONFLICT)
        self.points_um_pp[kept:] = points_um_pp
        return ""

    def _list_play(self, arguments: list[str], now_s: float) -> str:
        count = parse.whole(arguments[0], 2, self.lists.points)
        step_ms = parse.within(arguments[1], self.lists.step_ms, 1000 * self.limits.on_time_s)
        edge_ms = parse.within(arguments[2], self.lists.edge_ms, step_ms)
        self._require_cool(now_s)
        if self.state != "HOLD" or count != len(self.points_um_pp):
            raise Refusal(wire.SETTINGS_CONFLICT)
        self.played = Loop(
            amplitudes_um_pp=tuple(self.points_um_pp),
            step_s=step_ms / 1000,
            edge_s=edge_ms / 1000,
            mean_um_pp=self.target_um_pp,
        )
        self.state, self.target_um_pp = "LIST", fmean(self.points_um_pp)
        self._commanded_s = now_s
        drive = Drive(target_um_pp=self.target_um_pp, played=self.played, since_s=now_s)
        self.twin.set_drive(drive, now_s)
        return ""

    def _require_cool(self, now_s: float) -> None:
        if self.temperature_c(now_s) > HOTTEST_C:
            self.silence(now_s, "HOT")
            raise Refusal(wire.TOO_HOT)

    def _ramp(self, now_s: float) -> None:
        """Go on along the ramp; settling counts from when its end was really put on the plate."""
        part = min((now_s - self._commanded_s) / RAMP_S, 1)
        if self._arrived_s is None:
            self._now_um_pp = along_edge(self._from_um_pp, self.target_um_pp, part)
            self.twin.set_drive(Drive(target_um_pp=self._now_um_pp), now_s)
            self._arrived_s = now_s if part == 1 else None
        elif now_s - self._arrived_s < SETTLE_S:
            return
        elif self.target_um_pp == 0:
            self.silence(now_s)
        else:
            self._note_saturation(now_s)

    def _note_saturation(self, now_s: float) -> None:
        saturated = self.twin.voltage_v(now_s) >= self.twin.voltage_limit_v
        holds = "LIST" if self.played else "HOLD"
        self.state = "SAT" if saturated else holds


# header: (fewest and most arguments, what it does)
COMMANDS: dict[str, tuple[int, int, Callable[[Board, list[str], float], str]]] = {
    "*IDN?": (0, 0, lambda board, _, __: board.identity),
    "*RST": (0, 0, Board._reset),  # noqa: SLF001 - the table belongs to the class
    "SYST:ERR?": (0, 0, Board._error),  # noqa: SLF001
    "LIM?": (0, 0, lambda board, _, __: wire.format_limits(board.limits)),
    "AMPL": (1, 1, Board._amplitude),  # noqa: SLF001
    "DRIV": (2, 2, Board._open_loop),  # noqa: SLF001
    "OUTP": (1, 1, Board._output),  # noqa: SLF001
    "LIST:LIM?": (0, 0, lambda board, _, __: wire.format_list_limits(board.lists)),
    "LIST:AMPL": (2, 1 + wire.POINTS_A_LINE, Board._list_amplitudes),  # noqa: SLF001
    "LIST:PLAY": (3, 3, Board._list_play),  # noqa: SLF001
    "STAT?": (0, 0, lambda board, _, now_s: wire.format_status(board.status(now_s))),
}
