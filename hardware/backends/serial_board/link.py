"""Commands to the driver board, each acknowledged, checked, and executed once.

A command without a readable answer is repeated with the *same* sequence number; the board answers
a repetition from memory. Each answer contains the boot number, which reveals whether the board was
reset between the command and its repetition.
"""

from __future__ import annotations

from threading import Lock
from typing import Protocol

from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.clock import Clock, SystemClock
from slipscale.hardware.errors import (
    ConnectionLost,
    GarbledReply,
    OverLimit,
    PlateBusy,
    PlateFault,
    PlateRefused,
    PlateTimeout,
    WrongDevice,
)

REPLY_TIMEOUT_S = 0.08
ATTEMPTS = 4  # together shorter than the board's watchdog time
GREETING_S = 3.0  # many boards restart when their port is opened
CHATTER_S = 1.0  # and send arbitrary text while they start
FOREIGN_LINES = 3  # this many later lines that are not replies: another kind of device


class NotKnown(PlateRefused):
    """The board's firmware does not support the command."""


REFUSALS: dict[int, type[PlateFault]] = {
    wire.OUT_OF_RANGE: OverLimit,
    wire.BUSY: PlateBusy,
    wire.UNDEFINED_HEADER: NotKnown,
}


class Line(Protocol):
    """The interface of a line that the link requires."""

    port: str

    def write(self, data: bytes) -> None:
        """Send bytes."""

    def close(self) -> None:
        """Release the line."""

    def read(self) -> bytes:
        """Return the available bytes, waiting briefly for the first one."""


class BoardLink:
    """Sends commands to the board one at a time, from any thread.

    Parameters
    ----------
    line : Line
        An open line.
    clock : Clock
        Time base of the line; by default the machine's clock, whatever clock the session uses.
    """

    def __init__(self, line: Line, clock: Clock | None = None) -> None:
        self._line = line
        self._clock = clock or SystemClock()
        self._lock = Lock()
        self._sequence = 0
        self._boot: str | None = None
        self._buffer = b""
        self._foreign = 0

    def greet(self) -> str:
        """Return the board's ``*IDN?``, waiting for a board that is starting.

        Raises
        ------
        WrongDevice
            If the device does not use the board's protocol.
        PlateTimeout, GarbledReply, ConnectionLost, PlateBusy
            See `ask`.
        """
        self._boot = None
        begun_s = self._clock.now()
        foreign = 0
        while True:
            started = self._clock.now() - begun_s >= CHATTER_S
            try:
                return self.ask("*IDN?")
            except (PlateTimeout, GarbledReply) as fault:
                foreign += self._foreign if started else 0
                if foreign >= FOREIGN_LINES:
                    raise WrongDevice(
                        f"{self._line.port}: the device does not use the plate's protocol"
                    ) from fault
                if self._clock.now() - begun_s > GREETING_S:
                    raise

    def ask(self, body: str) -> str:
        """Send a command; return the value of its answer.

        Raises
        ------
        PlateTimeout
            If there is no answer, although the command was repeated.
        GarbledReply
            If answers were received, but none could be read.
        ConnectionLost
            If the device disappeared, or it has restarted since `greet`.
        OverLimit, PlateBusy, PlateRefused
            If the board understood the command and rejected it.
        """
        with self._lock:
            self._sequence = self._sequence % wire.LAST_SEQUENCE + 1
            frame = wire.command_frame(self._sequence, body)
            self._foreign = 0
            for _ in range(ATTEMPTS):
                self._line.write(frame)
                reply = self._await()
                if reply:
                    return self._value(reply, body)
        if self._foreign:
            raise GarbledReply(f"{self._line.port}: the answers to '{body}' cannot be read")
        raise PlateTimeout(f"{self._line.port}: the board did not answer '{body}'")

    def stop_now(self) -> None:
        """Send the stop byte immediately, even while another thread waits for an answer."""
        self._line.write(wire.STOP)

    def _await(self) -> wire.BoardReply | None:
        """Return the reply to the current command; discard everything else received meanwhile.

        Received bytes are processed before the time-out is checked, so that a thread that was
        delayed by the rest of its process still finds its reply.
        """
        end_s = self._clock.now() + REPLY_TIMEOUT_S
        while True:
            *lines, rest = (self._buffer + self._line.read()).split(b"\n")
            self._foreign += len(rest) > wire.LONGEST_LINE
            self._buffer = rest[-wire.LONGEST_LINE :]
            for line in lines:
                reply = wire.parse_reply(line)
                if reply is None:
                    self._foreign += 1
                elif reply.sequence == self._sequence:
                    return reply
            if self._clock.now() >= end_s:
                return None

    def _value(self, reply: wire.BoardReply, body: str) -> str:
        if self._boot is None:
            self._boot = reply.boot
        if reply.boot != self._boot:
            raise ConnectionLost(f"{self._line.port}: the board restarted, so its output is off")
        if reply.code != wire.OK:
            fault = REFUSALS.get(reply.code, PlateRefused)
            raise fault(f"the board refused '{body}': {reply.value} ({reply.code})")
        return reply.value
