"""Simulate a serial line to a board, and the operator of guided tests, in virtual time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.hardware.backends.serial_board.serial_line import BAUD
from slipscale.hardware.plate.dynamics import NO_FINGER, FingerLoad
from tests.support.virtual_time import TICKS_PER_S, VirtualTime, ticks

if TYPE_CHECKING:
    from slipscale.hardware.conformance.bench import Bench
    from slipscale.hardware.emulator.firmware import Board

ALIVE_TICKS = 100
LOAD = FingerLoad(loss=1 / 300)  # Q from 60 to 50


class VirtualLine(VirtualTime):
    """Serial line to a board, and the host to whose only port it belongs."""

    port = "virtual"

    def __init__(self, board: Board) -> None:
        super().__init__()
        self.board = board
        self.told = b""

    def open_line(self, port: str, *, baud: int = BAUD) -> VirtualLine:  # noqa: ARG002 - the only one
        """Open the port."""
        return self

    def write(self, data: bytes) -> None:
        """Send bytes to the board."""
        for _, reply in self.board.receive(data, self.now()):
            self.told += reply

    def close(self) -> None:
        """Release the line."""

    def read(self) -> bytes:
        """Return the bytes that the board has sent."""
        if not self.told:
            self.advance()
        data, self.told = self.told, b""
        return data

    def _run_devices(self) -> None:
        self.board.tick(self.now())


class Operator:
    """Performs the actions of the guided tests, with a correct second instrument."""

    def __init__(self, line: VirtualLine, bench: Bench) -> None:
        self._line, self._bench = line, bench
        self._twin = line.board.twin

    def load(self, *, on: bool) -> None:
        """Add or remove the load on the plate."""
        self._twin.amplitude_um_pp(self._line.now())
        self._twin.finger = LOAD if on else NO_FINGER

    def level(self) -> float:
        """Return the true amplitude."""
        return self._twin.amplitude_um_pp(self._line.now())

    def swing(self, duration_s: float) -> tuple[float, float]:
        """Return the smallest and the largest true amplitude within ``duration_s``."""
        seen = []
        for tick in range(ticks(duration_s)):
            self._line.sleep(1 / TICKS_PER_S)
            if tick % ALIVE_TICKS == 0:
                self._bench.status()
            seen.append(self.level())
        return min(seen), max(seen)

    def volts_peak(self) -> float:
        """Return the true voltage at the plate."""
        return self._twin.voltage_v(self._line.now())
