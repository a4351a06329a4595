"""Simulate a serial line to a board, and the operator of guided tests, in virtual time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.plate.dynamics import NO_FINGER, FingerLoad

if TYPE_CHECKING:
    from slipscale.hardware.conformance.bench import Bench
    from slipscale.hardware.emulator.firmware import Board

TICK_S = 0.001
ALIVE_TICKS = 100
LOAD = FingerLoad(loss=1 / 300)  # Q from 60 to 50


class VirtualLine:
    """Serial line to a board, in virtual time that advances only during waits."""

    port = "virtual"

    def __init__(self, board: Board) -> None:
        self.board = board
        self.clock = VirtualClock()
        self.told = b""

    def now(self) -> float:
        """Return the virtual time in seconds."""
        return self.clock.now()

    def sleep(self, duration_s: float) -> None:
        """Advance the virtual time in ticks of the board."""
        for _ in range(math.ceil(duration_s / TICK_S)):
            self.clock.sleep(TICK_S)
            self.board.tick(self.clock.now())

    def write(self, data: bytes) -> None:
        """Send bytes to the board."""
        for _, reply in self.board.receive(data, self.clock.now()):
            self.told += reply

    def close(self) -> None:
        """Release the line."""

    def read(self) -> bytes:
        """Return the bytes that the board has sent."""
        if not self.told:
            self.sleep(TICK_S)
        data, self.told = self.told, b""
        return data


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
        for tick in range(math.ceil(duration_s / TICK_S)):
            self._line.sleep(TICK_S)
            if tick % ALIVE_TICKS == 0:
                self._bench.status()
            seen.append(self.level())
        return min(seen), max(seen)

    def volts_peak(self) -> float:
        """Return the true voltage at the plate."""
        return self._twin.voltage_v(self._line.now())
