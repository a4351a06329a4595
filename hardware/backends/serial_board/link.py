"""Send commands to the driver board; each is acknowledged and executed exactly once.

If a command receives no readable answer, it is repeated with the *same* sequence number, and the
board repeats its answer without executing the command again. Each answer contains the boot number,
which reveals whether the board was reset since the last answer.
"""

from __future__ import annotations

from threading import Lock
from typing import Protocol

from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.clock import Clock
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
ATTEMPTS = 4  # All attempts together take less than the board's watchdog time.
GREETING_S = 3.0  # many boards restart when their port is opened
CHATTER_S = 1.0  # Many boards send arbitrary text while they start.
FOREIGN_LINES = 3  # number of invalid lines after which the device is not a board


class NotKnown(PlateRefused):
    """Raised if the board's firmware does not support a command."""


REFUSALS: dict[int, type[PlateFault]] = {
    wire.OUT_OF_RANGE: OverLimit,
    wire.BUSY: PlateBusy,
    wire.UNDEFINED_HEADER: NotKnown,
}


class Line(Protocol):
    """Interface for serial lines."""

    port: str

    def write(self, data: bytes) -> None:
        """Send bytes."""

    def close(self) -> None:
        """Release the line."""

    def read(self) -> bytes:
        """Return the available bytes, or wait briefly for a byte."""


class BoardLink:
    """Command interface to the board; sends one command at a time and is thread-safe.

    Parameters
    ----------
    line : Line
        An open line.
    clock : Clock
        Clock for time-outs.
    """

    def __init__(self, line: Line, clock: Clock) -> None:
        self._line = line
        self._clock = clock
        self._lock = Lock()
        self._sequence = 0
        self._boot: str | None = None
        self._buffer = b""
        self._foreign = 0

    def greet(self) -> str:
        """Return the board's answer to ``*IDN?``, after waiting for the board to start.

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
                        "{port}: the device does not use the plate's protocol", port=self._line.port
                    ) from fault
                if self._clock.now() - begun_s > GREETING_S:
                    raise

    def ask(self, body: str) -> str:
        """Send a command, and return the value in the answer.

        Raises
        ------
        PlateTimeout
            If the board does not answer even after the command was repeated.
        GarbledReply
            If the board answers, but none of its answers can be read.
        ConnectionLost
            If the device was disconnected, or if it has restarted since `greet`.
        OverLimit, PlateBusy, PlateRefused
            If the board rejects the command.
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
            raise GarbledReply(
                "{port}: the answers to {word} cannot be read",
                port=self._line.port,
                word=_word(body),
                level_free=True,
            )
        raise PlateTimeout(
            "{port}: the board did not answer {word}", port=self._line.port, word=_word(body)
        )

    def stop_now(self) -> None:
        """Send the stop byte immediately, even if another thread is waiting for an answer."""
        self._line.write(wire.STOP)

    def _await(self) -> wire.BoardReply | None:
        """Return the reply to the current command, and discard all other replies.

        Received bytes are processed before the time-out is checked, so that a reply is not missed
        if the thread was delayed.
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
            raise ConnectionLost(
                "{port}: the board restarted, so its output is off", port=self._line.port
            )
        if reply.code != wire.OK:
            fault = REFUSALS.get(reply.code, PlateRefused)
            raise fault(
                "the board refused {word}: {reason} ({code})",
                word=_word(body),
                reason=reply.value,
                code=reply.code,
                level_free=not any(character.isdigit() for character in reply.value),
            )
        return reply.value


def _word(body: str) -> str:
    """Return a command without its parameters, which contain amplitudes."""
    return body.partition(" ")[0]
