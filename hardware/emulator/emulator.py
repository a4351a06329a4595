"""Emulate a driver board with its port, faults and restarts.

The code performs no I/O except the log: it receives bytes and the time, and sends bytes to a
`Plug`. The same emulator therefore runs on a pseudo-terminal in real time
(`slipscale.hardware.emulator.pty`), and in tests in virtual time.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol, TextIO

from slipscale.hardware.backends.fault_injection import Injection, Schedule, parse_injections
from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.clock import Clock
from slipscale.hardware.emulator.firmware import IDENTITY, OLD_IDENTITY, Board
from slipscale.hardware.emulator.response_faults import (
    ANSWER_FAULTS,
    COMMAND_FAULTS,
    PHASES,
    RUN_FAULTS,
    UNHEARD,
    Answer,
    BoardAction,
    Piece,
    phase_of,
)
from slipscale.hardware.plate.dynamics import NO_FINGER, FingerLoad
from slipscale.hardware.plate.twin import Twin

FOREIGN_IDENTITY = "Hewlett-Packard,34401A,0,10-5-2"
NMEA = b"$GPGGA,101530.00,5036.10,N,00308.40,E,1,08,0.9,40.0,M,47.0,M,,*65\r\n"
NMEA_S = 0.05


class EmulatedBoard(Protocol):
    """Common interface for boards emulated in Python and boards compiled from the firmware."""

    hot: bool
    busy: bool

    @property
    def state(self) -> str:
        """State that ``STAT?`` would report."""

    @property
    def target_level(self) -> float:
        """Commanded amplitude or, for a list, the mean amplitude."""

    @property
    def vibrates(self) -> bool:
        """Whether the output is on."""

    def receive(self, data: bytes, now_s: float) -> list[tuple[str, bytes]]:
        """Process received bytes; return (command, reply) for each complete command."""

    def tick(self, now_s: float) -> None:
        """Advance the board to the given time."""

    def silence(self, now_s: float) -> None:
        """Switch the output off."""

    def commanded_level(self, now_s: float) -> float:
        """Return the amplitude that the board commands at a given time."""


class Plug(Protocol):
    """Interface for the board's end of a serial line to a host."""

    def plug_in(self) -> None:
        """Make the port available to hosts."""

    def unplug(self) -> None:
        """Remove the port; hosts lose their connection."""

    def send(self, data: bytes) -> None:
        """Send bytes to the host, if there is one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BoardMake:
    """Kind of board that is emulated.

    Parameters
    ----------
    back_s : float
        Time after which an unplugged, busy, unresponsive or overheated board recovers; 0 means
        never.
    dtr : bool
        Whether the board notices that the host closed the port. If True, the board then silences
        the plate and restarts, like a board with automatic reset. If False, only the watchdog
        silences the plate.
    firmware : callable
        Function that creates a board with the compiled firmware, see
        `slipscale.hardware.emulator.compiled`; by default, the board is emulated in Python.
    limits : BoardLimits
        Limits of the emulated board; it silences itself if it receives nothing for ``watchdog_ms``.
    unit : str
        Unit of the emulated board's amplitudes.
    """

    back_s: float
    dtr: bool
    firmware: Callable[[Twin, int, float], EmulatedBoard] | None
    limits: wire.BoardLimits
    unit: str


class Emulator:
    """Emulated board with fault injection.

    Parameters
    ----------
    plug : Plug
        The board's end of the serial line.
    clock : Clock
        The machine's clock.
    injections : iterable of Injection
        Faults to inject; phases are those of `slipscale.hardware.emulator.response_faults`.
    twin : Twin
        Simulated plate that the board drives.
    log : TextIO
        File to which the plate's state and amplitude are written, one line per millisecond.
    make : BoardMake
        What kind of board is emulated.
    """

    def __init__(
        self,
        plug: Plug,
        *,
        clock: Clock,
        make: BoardMake,
        twin: Twin,
        injections: Iterable[Injection] = (),
        log: TextIO | None = None,
    ) -> None:
        orders = list(injections)
        self._run_faults = {each.fault for each in orders} & set(RUN_FAULTS)
        self._schedule = Schedule(each for each in orders if each.fault not in RUN_FAULTS)
        self._plug = plug
        self._clock = clock
        self._make, self._twin = make, twin
        self.board: EmulatedBoard
        self._boots = 0
        self._line = b""
        self._previous = b""
        self._outbox: deque[tuple[float, bytes | BoardAction]] = deque()
        self._presented: list[float] = []
        self._list: list[float] = []
        self._played: list[list[float]] = []
        self._log = log
        self._logged_ms = round(clock.now() * 1000)
        self._note("time_s,state,commanded_level,amplitude_um_pp")
        self._back_at_s: float | None
        self._nmea_at_s = 0.0
        self._plugged = True
        self._boot()
        plug.plug_in()

    def state(self) -> dict[str, object]:
        """Return the state of the board and the plate, as printed to standard output.

        ``amplitude_um_pp`` is the true simulated amplitude. ``presented_levels`` contains the
        commanded amplitudes, and ``played`` contains the amplitude lists that were played. Commands
        that the host repeats are included only once.
        """
        now_s = self._now()
        self.board.tick(now_s)
        return {
            "state": self.board.state,
            "target_level": self.board.target_level,
            "amplitude_um_pp": self._twin.amplitude_um_pp(now_s),
            "vibrates": self.board.vibrates,
            "boots": self._boots,
            "plugged": self._plugged,
            "presented_levels": self._presented,
            "played": self._played,
        }

    def order(self, text: str) -> None:
        """Inject faults, written as for ``--fault`` but counted from now. Raises ValueError."""
        for each in parse_injections(text, faults=(*ANSWER_FAULTS, *COMMAND_FAULTS), phases=PHASES):
            self._schedule.add(each)

    def cancel(self) -> None:
        """Remove all pending faults."""
        self._schedule.clear()

    def touch(self, finger: FingerLoad = NO_FINGER) -> None:
        """Put a finger on the plate, or remove the finger."""
        self._twin.amplitude_um_pp(self._now())  # Simulates the time before the load changes.
        self._twin.finger = finger

    def unplug(self) -> None:
        """Unplug the board, which also cuts its power."""
        if self._plugged:
            self.board.silence(self._now())
            self._plug.unplug()
            self._plugged = False
            self._outbox.clear()
            self._come_back_later()

    def come_back(self) -> None:
        """Plug the board in and restart it."""
        self._boot()
        if not self._plugged:
            self._plug.plug_in()
            self._plugged = True

    @property
    def active(self) -> bool:
        """Whether the plate vibrates or answers remain to be sent, so that each tick matters."""
        return self.board.vibrates or bool(self._outbox)

    def advance(self) -> None:
        """Advance the board to the current time, and send the answers that are due."""
        now_s = self._now()
        self.board.tick(now_s)
        self._send_what_is_due()
        if self._back_at_s is not None and now_s >= self._back_at_s:
            self.come_back()
        if "nmea" in self._run_faults and now_s >= self._nmea_at_s:
            self._nmea_at_s = now_s + NMEA_S
            self._plug.send(NMEA)

    def receive(self, data: bytes) -> None:
        """Process bytes from the host."""
        for byte in data:
            self._take(bytes([byte]))

    def host_left(self) -> None:
        """Process that the host closed the port."""
        if self._make.dtr:
            self._boot()

    def _boot(self) -> None:
        if self._boots:
            self.board.silence(self._now())
        self._boots += 1
        self._back_at_s = None
        self._deaf = "nmea" in self._run_faults
        self._line = b""
        self._outbox.clear()
        old = "old_firmware" in self._run_faults
        identity = OLD_IDENTITY if old else IDENTITY
        if "wrong_identity" in self._run_faults:
            identity = FOREIGN_IDENTITY
        if self._make.firmware:
            self.board = self._make.firmware(self._twin, self._boots, self._make.limits.watchdog_ms)
        else:
            self.board = Board(
                self._twin,
                boot=self._boots,
                identity=identity,
                lists=not old,
                limits=self._make.limits,
                unit=self._make.unit,
            )

    def _take(self, byte: bytes) -> None:
        if self._deaf:
            return
        if byte == wire.STOP:
            self.board.receive(byte, self._now())
            self._line = b""
            return
        if byte == b"\n" or len(self._line) <= wire.LONGEST_LINE:
            self._line += byte
        if byte == b"\n":
            line, self._line = self._line, b""
            self._pass_on(line)

    def _pass_on(self, line: bytes) -> None:
        command = wire.parse_command(line.rstrip())
        header = command[1].partition(" ")[0] if command else ""
        faults = self._schedule.due(phase_of(header)) if command else []
        for fault in faults:
            if fault in COMMAND_FAULTS:
                self._act(COMMAND_FAULTS[fault])
                if COMMAND_FAULTS[fault] in UNHEARD:
                    return
        for body, reply in self.board.receive(line, self._now()):
            if reply != self._previous and b" 0 *" in reply:
                self._remember(body)
            answer, self._previous = Answer(reply, self._previous), reply
            spoiled = [ANSWER_FAULTS[fault](answer) for fault in faults if fault in ANSWER_FAULTS]
            self._post(spoiled[0] if spoiled else [reply])

    def _remember(self, body: str) -> None:
        """Record an accepted command, to be reported by `state`."""
        header, _, arguments = body.partition(" ")
        if header == "AMPL":
            self._presented.append(float(arguments))
        elif header == "LIST:AMPL":
            first, *points = map(float, arguments.split(","))
            self._list[int(first) - 1 :] = points
        elif header == "LIST:PLAY":
            self._played.append(list(self._list))

    def _now(self) -> float:
        """Return the current time, after writing the log up to this time."""
        now_s = self._clock.now()
        while self._log and self._logged_ms + 1 <= now_s * 1000:
            self._logged_ms += 1
            at_s = self._logged_ms / 1000
            commanded = self.board.commanded_level(at_s)
            amplitude_um_pp = self._twin.amplitude_um_pp(at_s)
            self._note(f"{at_s:.3f},{self.board.state},{commanded:.4f},{amplitude_um_pp:.4f}")
        return now_s

    def _note(self, line: str) -> None:
        if self._log:
            self._log.write(line + "\n")

    def _post(self, pieces: Iterable[Piece]) -> None:
        due_s = max(self._now(), self._outbox[-1][0] if self._outbox else 0.0)
        for piece in pieces:
            if isinstance(piece, float):
                due_s += piece
            else:
                self._outbox.append((due_s, piece))
        self._send_what_is_due()

    def _send_what_is_due(self) -> None:
        while self._outbox and self._outbox[0][0] <= self._now():
            _, piece = self._outbox.popleft()
            if isinstance(piece, BoardAction):
                self._act(piece)
            else:
                self._plug.send(piece)

    def _act(self, act: BoardAction) -> None:
        if act is BoardAction.UNPLUG:
            self.unplug()
            return
        if act is BoardAction.RESET:
            self._boot()
            return
        self.board.busy |= act is BoardAction.BUSY
        self.board.hot |= act is BoardAction.HOT
        self._deaf |= act is BoardAction.DEAFEN
        self._come_back_later()

    def _come_back_later(self) -> None:
        self._back_at_s = self._now() + self._make.back_s if self._make.back_s else None
