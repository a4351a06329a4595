"""Deliberately faulty variants of the emulated board."""

# ruff: noqa: D102 - the variants override methods of Board

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.emulator import firmware
from slipscale.hardware.emulator.firmware import Board

if TYPE_CHECKING:
    from slipscale.hardware.backends.serial_board.protocol import BoardStatus
    from slipscale.hardware.plate.twin import Twin


class Variant(Board):
    """Emulated board in which subclasses can override the commands."""

    def __init__(self, twin: Twin, *, boot: int) -> None:
        super().__init__(twin, boot=boot)
        self._commands = {
            header: (fewest, most, getattr(type(self), run.__name__, run))
            for header, (fewest, most, run) in self._commands.items()
        }


class NoWatchdog(Variant):
    """The board has no watchdog."""

    unwatched: tuple[str, ...] = wire.VIBRATING

    def tick(self, now_s: float) -> None:
        if self.state in self.unwatched:
            self._heard_s = now_s
        super().tick(now_s)


class NoWatchdogInList(NoWatchdog):
    """The board has no watchdog while it plays a list."""

    unwatched = ("LIST",)


class NoWatchdogInOpen(NoWatchdog):
    """The board has no watchdog in open loop."""

    unwatched = ("OPEN",)


class ContentWatchdog(Variant):
    """Any received byte resets the watchdog."""

    def receive(self, data: bytes, now_s: float) -> list[tuple[str, bytes]]:
        self._heard_s = now_s
        return super().receive(data, now_s)


class FakesSilence(Variant):
    """The board reports that it is silent after the event ``cause``, but drives the plate."""

    cause = "OUTP"
    faked = False

    def silence(self, now_s: float, state: str = "OFF") -> None:
        drive = self.twin.drive
        super().silence(now_s, state)
        self.faked = self._is_cause(state)
        if self.faked:
            self.twin.set_drive(drive, now_s)

    def _is_cause(self, state: str) -> bool:
        return self.cause == state or (state == "OFF" and self._doing == self.cause)

    _doing = ""

    def _run(self, body: str, now_s: float) -> str:
        self._doing = body.partition(" ")[0]
        try:
            return super()._run(body, now_s)
        finally:
            self._doing = ""

    def receive(self, data: bytes, now_s: float) -> list[tuple[str, bytes]]:
        answers = []
        for byte in data:
            self._doing = "!" if byte == wire.STOP[0] else ""
            answers += super().receive(bytes([byte]), now_s)
        return answers

    def status(self, now_s: float) -> BoardStatus:
        status = super().status(now_s)
        return replace(status, voltage_v=0.0) if self.state not in wire.VIBRATING else status


class FakesSilenceAfterStop(FakesSilence):
    """The board falsely reports that it is silent after the stop byte ``!``."""

    cause = "!"


class FakesSilenceAfterWatchdog(FakesSilence):
    """The board falsely reports that it is silent after the watchdog has expired."""

    cause = "WDOG"


class FakesSilenceAndReading(FakesSilence):
    """The board falsely reports silence and a sensor reading of 0 after it was switched off."""

    def status(self, now_s: float) -> BoardStatus:
        status = super().status(now_s)
        return replace(status, level=0.0) if self.faked else status


class DeafToStopInOpen(Variant):
    """The board ignores the stop byte ``!`` in open loop."""

    def receive(self, data: bytes, now_s: float) -> list[tuple[str, bytes]]:
        if self.state == "OPEN":
            data = data.replace(wire.STOP, b"")
        return super().receive(data, now_s)


class FalseHold(Variant):
    """The board reports HOLD after each ramp, whatever the sensor measures."""

    def _settled(self, measured_level: float, *, was_limited: bool) -> str:
        super()._settled(measured_level, was_limited=was_limited)
        return "HOLD"


class WideHold(Variant):
    """The board reports HOLD within 10 % of the target, and corrects no error in that band."""

    def _settled(self, measured_level: float, *, was_limited: bool) -> str:
        if abs(measured_level - self.target_level) <= 0.1 * self.target_level:
            return "HOLD"
        return super()._settled(measured_level, was_limited=was_limited)

    def _correct(self, measured_level: float, largest_level: float) -> bool:
        if abs(measured_level - self.target_level) <= 0.1 * self.target_level:
            return True
        return super()._correct(measured_level, largest_level)


class NoSaturation(Variant):
    """The board reports HOLD although the voltage is insufficient."""

    def _settled(self, measured_level: float, *, was_limited: bool) -> str:
        state = super()._settled(measured_level, was_limited=was_limited)
        return "HOLD" if state == "SAT" or was_limited else state


class DoubledLimit(Variant):
    """In closed loop, the board applies up to twice its voltage limit."""

    def __init__(self, twin: Twin, *, boot: int) -> None:
        super().__init__(twin, boot=boot)
        twin.voltage_limit_v *= 2


class FrozenReadback(Variant):
    """The sensor's reading freezes at its first value above 0.1 µm in HOLD."""

    _frozen: float | None = None

    def status(self, now_s: float) -> BoardStatus:
        status = super().status(now_s)
        reading = status.level or 0.0
        if self._frozen is None and self.state == "HOLD" and reading > 0.1:  # noqa: PLR2004
            self._frozen = reading
        return replace(status, level=self._frozen or reading)


class EchoedReadback(Variant):
    """The board reports the target as the sensor's reading."""

    def status(self, now_s: float) -> BoardStatus:
        status = super().status(now_s)
        return replace(status, level=status.target_level)


class FakedReadback(EchoedReadback):
    """The reading is computed from the drive, and is half of the true amplitude."""

    def __init__(self, twin: Twin, *, boot: int) -> None:
        super().__init__(twin, boot=boot)
        self._nominal_volts_per_level *= 2
        self._volts_per_level = self._nominal_volts_per_level

    def _settled(self, measured_level: float, *, was_limited: bool) -> str:
        return super()._settled(self.target_level + 0 * measured_level, was_limited=was_limited)

    def _correct(self, measured_level: float, largest_level: float) -> bool:  # noqa: ARG002
        return True

    def status(self, now_s: float) -> BoardStatus:
        status = super().status(now_s)
        um_pp = status.voltage_v / self._nominal_volts_per_level
        off_hz = abs(status.frequency_hz - self.twin.conditions(now_s).resonance_hz)
        return replace(status, level=um_pp if off_hz < 100 else um_pp / 20)  # noqa: PLR2004


class StepsInsteadOfRamp(Variant):
    """The board changes the amplitude at once, without a ramp."""

    def _ramp(self, now_s: float) -> None:
        self._commanded_s -= firmware.RAMP_S
        super()._ramp(now_s)
        self._commanded_s += firmware.RAMP_S
        if self.target_level == 0:
            self.silence(now_s)

    def _amplitude(self, arguments: list[str], now_s: float) -> str:
        value = super()._amplitude(arguments, now_s)
        if self.state == "RAMP":
            self._ramp(now_s)
        return value


class NoOnTimeLimit(Variant):
    """The board does not limit the on-time."""

    def tick(self, now_s: float) -> None:
        if not self.played and self.state != "RAMP":
            self._commanded_s = now_s
        super().tick(now_s)


class SlowList(Variant):
    """The board plays lists at half speed."""

    def _list_play(self, arguments: list[str], now_s: float) -> str:
        value = super()._list_play(arguments, now_s)
        if self.played:
            self.played = replace(self.played, step_s=2 * self.played.step_s)
            self._apply(now_s)
        return value


class ChangedList(Variant):
    """The board plays a different list from the one it received."""

    def _list_play(self, arguments: list[str], now_s: float) -> str:
        value = super()._list_play(arguments, now_s)
        if self.played:
            points = self.change(self.played.levels)
            self.played = replace(self.played, levels=points)
            self._apply(now_s)
        return value

    def change(self, points: tuple[float, ...]) -> tuple[float, ...]:
        """Return the list to play."""
        return points


class FlatList(ChangedList):
    """The board plays only the mean of a list."""

    def change(self, points: tuple[float, ...]) -> tuple[float, ...]:
        return (sum(points) / len(points),) * len(points)


class InvertedList(ChangedList):
    """The board plays lists that are mirrored about their mean."""

    def change(self, points: tuple[float, ...]) -> tuple[float, ...]:
        mean = sum(points) / len(points)
        return tuple(max(2 * mean - each, 0.0) for each in points)


class CutList(ChangedList):
    """The board plays only the first eight points of a list."""

    def change(self, points: tuple[float, ...]) -> tuple[float, ...]:
        return points[: wire.POINTS_A_LINE]


class DoubledDrive(Variant):
    """DRIV applies twice the voltage to the plate, and reports the commanded one."""

    def _open_loop(self, arguments: list[str], now_s: float) -> str:
        value = super()._open_loop(arguments, now_s)
        doubled = replace(self.twin.drive, voltage_v=2 * self.twin.drive.voltage_v)
        self.twin.set_drive(doubled, now_s)
        return value

    def status(self, now_s: float) -> BoardStatus:
        status = super().status(now_s)
        return replace(status, voltage_v=status.voltage_v / 2) if self.state == "OPEN" else status


class ForgetsNotAtStop(Variant):
    """The board runs a frame that contains ``!``, because it removes only this byte."""

    def receive(self, data: bytes, now_s: float) -> list[tuple[str, bytes]]:
        before, stop, after = data.partition(wire.STOP)
        if not stop:
            return super().receive(data, now_s)
        answers = super().receive(before, now_s)
        self.silence(now_s)
        return answers + self.receive(after, now_s)


class ForgetsItsAnswer(Variant):
    """A plain ``*IDN?`` deletes the answer stored for repeated commands."""

    def _line(self, line: bytes, now_s: float) -> tuple[str, bytes] | None:
        if line == b"*IDN?":
            self._last = None
        return super()._line(line, now_s)


class CutsLines(Variant):
    """The board truncates lines that are too long, and executes them."""

    def receive(self, data: bytes, now_s: float) -> list[tuple[str, bytes]]:
        *lines, rest = data.split(b"\n")
        whole = [line[: wire.LONGEST_LINE] + b"\n" for line in lines]
        return super().receive(b"".join(whole) + rest, now_s)


class AnswersTwice(Variant):
    """The board sends each answer twice."""

    def receive(self, data: bytes, now_s: float) -> list[tuple[str, bytes]]:
        return [each for each in super().receive(data, now_s) for _ in range(2)]


class NoLimits(Variant):
    """The board does not enforce its amplitude limit."""

    def _amplitude(self, arguments: list[str], now_s: float) -> str:
        kept, self.limits = self.limits, replace(self.limits, level=1e9)
        try:
            return super()._amplitude(arguments, now_s)
        finally:
            self.limits = kept


WRONG: tuple[type[Board], ...] = (
    NoWatchdog, NoWatchdogInList, NoWatchdogInOpen, ContentWatchdog,
    FakesSilence, FakesSilenceAfterStop, FakesSilenceAfterWatchdog, FakesSilenceAndReading,
    DeafToStopInOpen, FalseHold, WideHold, NoSaturation,
    FrozenReadback, EchoedReadback, FakedReadback, StepsInsteadOfRamp, NoOnTimeLimit,
    SlowList, FlatList, InvertedList, CutList, DoubledDrive,
    ForgetsNotAtStop, ForgetsItsAnswer, CutsLines, AnswersTwice, NoLimits, DoubledLimit,
)  # fmt: skip
# Boards that only guided tests may detect: their answers are consistent if the plate is unloaded.
GUIDED_ONLY = (FakesSilenceAndReading, FalseHold, WideHold, NoSaturation)
