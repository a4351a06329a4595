"""Control an emulated board by the lines of input that `slipscale plate emulate` reads."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any


class ControlledBoard(ABC):
    """Emulated board with its control channel, in another process or in virtual time.

    Attributes
    ----------
    port : str
        The port for ``serial:PORT``.
    """

    port: str

    def state(self) -> dict[str, Any]:
        """Return the board's state and the plate's actual amplitude."""
        return self._tell("state")

    def fault(self, order: str) -> dict[str, Any]:
        """Inject a fault at the next command (NAME) or the N-th of a phase (NAME@PHASE/N)."""
        return self._tell(f"fault {order}")

    def no_faults(self) -> dict[str, Any]:
        """Remove pending faults."""
        return self._tell("no faults")

    def unplug(self) -> dict[str, Any]:
        """Unplug the board now."""
        return self._tell("unplug")

    def back(self) -> dict[str, Any]:
        """Plug the board in and restart it now."""
        return self._tell("back")

    def finger(self, *, on: bool = True) -> dict[str, Any]:
        """Put a finger on the plate that reduces its Q from 60 to 50, or remove it."""
        return self._tell("finger" if on else "no finger")

    def _tell(self, line: str) -> dict[str, Any]:
        answer = self._answer_to(line)
        if "error" in answer:
            raise ValueError(answer["error"])
        return answer

    @abstractmethod
    def _answer_to(self, line: str) -> dict[str, Any]:
        """Return the answer to a line of input."""
