"""Simulate the connection to a function generator, which can be slow or lost, in virtual time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.hardware.backends.generator_line import TIMEOUT_MS, GeneratorLine
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.errors import ConnectionLost, PlateNotFound, PlateTimeout

if TYPE_CHECKING:
    from slipscale.hardware.emulator.generators import SimulatedGenerator


class LocalLine(GeneratorLine):
    """Connection to a simulated generator in this process.

    Parameters
    ----------
    generator : SimulatedGenerator

    Attributes
    ----------
    clock : VirtualClock
        Clock that advances while the connection waits for an answer.
    command_s : float
        Time that the generator takes for each command; commands that arrive earlier are queued.
    wire : list of str
        Commands that were sent.
    drop_at : int or None
        Number of the command at which the connection is lost before the generator receives it;
        once, or ``for_good``.
    """

    def __init__(self, generator: SimulatedGenerator) -> None:
        super().__init__("SIMULATED::INSTR")
        self.generator = generator
        self.clock = VirtualClock()
        self.command_s = 0.0
        self._free_s = 0.0  # when the generator has executed all commands
        self.wire: list[str] = []
        self.drop_at: int | None = None
        self.for_good = False
        self._open = False

    @property
    def opened(self) -> bool:
        """Whether the connection is open."""
        return self._open

    def open(self) -> None:
        """Open the connection."""
        if self.for_good and self.drop_at is not None and len(self.wire) >= self.drop_at:
            raise PlateNotFound(f"{self.resource}: cannot be opened")
        self._open = True

    def release(self) -> None:
        """Close the connection."""
        self._open = False

    def write(self, command: str) -> None:
        """Send a command."""
        self._hear(command)

    def ask(self, query: str) -> str:
        """Return the answer to a query."""
        answer = self._hear(query)
        wait_s = self._free_s - self.clock.now()
        self.clock.sleep(min(wait_s, TIMEOUT_MS / 1000))
        if answer is None or wait_s > TIMEOUT_MS / 1000:
            raise PlateTimeout(f"{self.resource}: no answer")
        return answer

    def _hear(self, line: str) -> str | None:
        if not self._open:
            raise ConnectionLost(f"{self.resource}: not connected")
        self.wire.append(line)
        self._free_s = max(self._free_s, self.clock.now()) + self.command_s
        if len(self.wire) == self.drop_at:
            self._open = False
            raise ConnectionLost(f"{self.resource}: the device went away")
        return self.generator.hear(line)
