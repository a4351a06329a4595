"""Simulate the connection to a function generator, which can be lost."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.hardware.backends.generator_line import GeneratorLine
from slipscale.hardware.errors import ConnectionLost, PlateNotFound, PlateTimeout

if TYPE_CHECKING:
    from slipscale.hardware.emulator.generators import SimulatedGenerator


class LocalLine(GeneratorLine):
    """Connection to a simulated generator in this process, without delay.

    Parameters
    ----------
    generator : SimulatedGenerator

    Attributes
    ----------
    wire : list of str
        Commands that were sent.
    drop_at : int or None
        Number of the command at which the connection is lost before the generator receives it;
        once, or ``for_good``.
    """

    def __init__(self, generator: SimulatedGenerator) -> None:
        super().__init__("SIMULATED::INSTR")
        self.generator = generator
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
        if answer is None:
            raise PlateTimeout(f"{self.resource}: no answer")
        return answer

    def _hear(self, line: str) -> str | None:
        if not self._open:
            raise ConnectionLost(f"{self.resource}: not connected")
        self.wire.append(line)
        if len(self.wire) == self.drop_at:
            self._open = False
            raise ConnectionLost(f"{self.resource}: the device went away")
        return self.generator.hear(line)
