"""Send bytes to a driver board, and check the answers against the protocol.

The serial line and the clock are arguments, so tests can run the same checks in virtual time on
emulated boards.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NoReturn

from slipscale.faults.message import Message
from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.backends.serial_board.link import Line
from slipscale.hardware.clock import Clock

ANSWER_S = 0.08  # time without an answer after which a host repeats a command
LATEST_S = 0.32  # longest waiting time for an expected answer
ALIVE_S = 0.1  # interval at which a host queries the status
SETTLING_S = 2.0
GREETING_S = 3.5
UNIT = "µm p-p"
SHOWN = 60  # number of characters of an unexpected answer in messages


class Departure(Exception):
    """Raised if a device violates a rule; reports the expected and the received answer."""


class NotApplicable(Exception):
    """Raised if a rule does not apply, for example because the device lacks a feature."""


class NotProved(Exception):
    """Raised if a check needs an option of ``slipscale plate conform``, which was not given."""


class Bench:
    """Test bench that sends lines to a board and checks the answers.

    Parameters
    ----------
    line : Line
        Connection to the board, which must be open.
    clock : Clock
        Clock for time-outs.
    long : bool
        Whether to include checks that take minutes.
    """

    def __init__(self, line: Line, clock: Clock, *, long: bool = False) -> None:
        self.long = long
        self._line = line
        self._clock = clock
        self._buffer = b""
        self._sequence = 0
        self.limits = wire.BoardLimits()
        self.unit = UNIT  # as in messages

    def greet(self) -> None:
        """Wait until a newly connected board answers, then read its limits.

        Raises
        ------
        Departure
            If the board does not answer, or reports impossible limits.
        """
        end_s = self._clock.now() + GREETING_S
        while not any(map(wire.parse_reply, self.answers_to(self.frame("*IDN?")))):
            if self._clock.now() > end_s:
                raise Departure(
                    "no answer to *IDN?; expected an answer within 2.5 s of opening the port"
                )
        self.ask("*RST")
        unit = self.run("UNIT?")
        if unit.code == wire.OK and unit.value != wire.UNIT:
            self.unit = unit.value
        try:
            self.limits = wire.parse_limits(self.ask("LIM?"))
        except ValueError as error:
            raise Departure(Message("LIM?: {error}", error=error)) from error

    def frame(self, body: str, sequence: int | None = None) -> bytes:
        """Encode a command with the given or the next sequence number."""
        if sequence is None:
            self._sequence = self._sequence % wire.LAST_SEQUENCE + 1
            sequence = self._sequence
        return wire.command_frame(sequence, body)

    def answers_to(self, data: bytes, *, at_most: int | None = None) -> list[bytes]:
        """Send bytes, and return up to ``at_most`` lines that arrive within the time limit."""
        self._line.write(data)
        lines: list[bytes] = []
        end_s = self._clock.now() + (ANSWER_S if at_most is None else LATEST_S)
        while True:
            *whole, self._buffer = (self._buffer + self._line.read()).split(b"\n")
            lines += whole
            if len(lines) == at_most or self._clock.now() >= end_s:
                return lines

    def drain(self) -> None:
        """Discard late answers, so that they do not affect later checks."""
        end_s = self._clock.now() + SETTLING_S
        while self.answers_to(b"") and self._clock.now() < end_s:
            pass

    def silence(self) -> None:
        """Switch the plate off, and discard late answers."""
        self.answers_to(wire.STOP + b"\n" + self.frame("OUTP OFF"), at_most=1)
        self.drain()

    def send(self, data: bytes) -> None:
        """Send bytes to the board without waiting for an answer."""
        self._line.write(data)

    def expect_silence(self, data: bytes, why: str) -> None:
        """Send bytes, and check that the board does not answer."""
        if lines := self.answers_to(data):
            differs(
                Message("no answer to {why}, {sent}", why=why, sent=_shown(data)),
                _shown(lines[0]),
            )

    def reply_to(self, data: bytes, what: str | None = None) -> wire.BoardReply:
        """Send bytes that contain one correct frame, and return the answer to this frame."""
        what = what or _shown(data)
        lines = self.answers_to(data, at_most=1)
        reply = wire.parse_reply(lines[0]) if lines else None
        if reply is None:
            differs(
                Message("an answer to {what}", what=what), _shown(lines[0]) if lines else "none"
            )
        return reply

    def run(self, body: str) -> wire.BoardReply:
        """Send a command, and return the answer regardless of its code."""
        frame = self.frame(body)
        reply = self.reply_to(frame, f"'{body}'")
        if reply.sequence != self._sequence:
            differs(
                Message(
                    "SEQ {sequence} in the answer to '{body}'", sequence=self._sequence, body=body
                ),
                str(reply.sequence),
            )
        return reply

    def ask(self, body: str) -> str:
        """Send a command that the board must accept, and return the value in the answer."""
        self.expect_code(body, wire.OK)
        return self._value

    def expect_code(self, body: str, code: int) -> None:
        """Send a command, and check the code and any error text in the answer."""
        reply = self.run(body)
        if reply.code != code:
            differs(Message("code {code} for '{body}'", code=code, body=body), str(reply.code))
        if code != wire.OK and reply.value != wire.MEANINGS[code]:
            differs(
                Message(
                    "the text '{meanings}' for '{body}'", meanings=wire.MEANINGS[code], body=body
                ),
                f"'{reply.value}'",
            )
        self._value = reply.value

    def status(self) -> wire.BoardStatus:
        """Return the board's status."""
        value = self.ask("STAT?")
        try:
            return wire.parse_status(value)
        except ValueError:
            differs("six values in the answer to STAT?", f"'{value}'")

    def expect_state(self, *states: str) -> wire.BoardStatus:
        """Return the status, after checking that its state is one of ``states``."""
        status = self.status()
        if status.state not in states:
            differs(f"state {' or '.join(states)}", status.state)
        return status

    def wait(self, duration_s: float, meanwhile: Callable[[], object] | None = None) -> None:
        """Wait, calling ``meanwhile`` every 0.1 s (default: query the status, as a host would)."""
        end_s = self._clock.now() + duration_s
        while self._clock.now() < end_s:
            (meanwhile or self.status)()
            self._clock.sleep(min(ALIVE_S, max(end_s - self._clock.now(), 0.0)))

    def settle(self, level: float) -> wire.BoardStatus:
        """Command an amplitude; return the first status with the state HOLD (or OFF for 0)."""
        self.ask(f"AMPL {level:.4f}")
        return self.wait_for("HOLD" if level else "OFF")

    def wait_for(self, state: str) -> wire.BoardStatus:
        """Wait until a ramp ends, check the state of the board, and return the status."""
        end_s = self._clock.now() + SETTLING_S
        while (status := self.status()).state == "RAMP":
            if self._clock.now() > end_s:
                differs(
                    Message(
                        "{state} within {settling_s:g} s of AMPL",
                        state=state,
                        settling_s=SETTLING_S,
                    ),
                    "RAMP",
                )
            self._clock.sleep(0.005)
        if status.state != state:
            differs(Message("{state} after the ramp", state=state), status.state)
        return status

    @property
    def some_level(self) -> float:
        """Amplitude for checks: 40 % of the limit, such as 1 µm if the limit is 2.5 µm."""
        return round(0.4 * self.limits.level, 4)

    def lists(self) -> wire.ListLimits:
        """Return the limits for amplitude lists. Raises NotApplicable if there are none."""
        reply = self.run("LIST:LIM?")
        if reply.code == wire.UNDEFINED_HEADER:
            raise NotApplicable("the board does not support amplitude lists")
        try:
            return wire.parse_list_limits(reply.value)
        except ValueError as error:
            raise Departure(Message("LIST:LIM?: {error}", error=error)) from error

    def expect_unchanged(self, body: str, status: wire.BoardStatus) -> None:
        """Check that a command did not change the status of the plate."""
        now = self.status()
        unchanged = replace(
            now, level=status.level, temperature_c=status.temperature_c,
            frequency_hz=status.frequency_hz, voltage_v=status.voltage_v,
        )  # fmt: skip
        if unchanged != status:
            differs(
                Message("an unchanged plate after '{body}' was refused", body=body),
                wire.format_status(now),
            )


def differs(expected: str, got: str) -> NoReturn:
    """Raise a `Departure` that reports the expected and the received answer."""
    raise Departure(Message("expected {expected}; got {got}", expected=expected, got=got))


def _shown(data: bytes) -> str:
    text = data.decode("ascii", "backslashreplace").encode("unicode_escape").decode("ascii")
    return f"'{text[:SHOWN]}{'...' if len(text) > SHOWN else ''}'"
