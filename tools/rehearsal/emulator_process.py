"""An emulated board in a separate process, with its control channel, for rehearsals and tests."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any, Self

from slipscale.faults import RigError


class EmulatorProcess:
    """Run ``slipscale plate emulate`` within a ``with`` block.

    Parameters
    ----------
    *arguments : str
        Arguments of ``slipscale plate emulate``.

    Attributes
    ----------
    port : str
        The port for ``serial:PORT``.
    """

    def __init__(self, *arguments: str) -> None:
        command = [sys.executable, "-m", "slipscale", "plate", "emulate", *arguments]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.port = self._answer()

    @property
    def process_id(self) -> int:
        """Process id."""
        return self._process.pid

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

    def close(self) -> None:
        """End the process."""
        self._process.terminate()
        self._process.communicate()

    def _tell(self, line: str) -> dict[str, Any]:
        if self._process.stdin is not None:
            self._process.stdin.write(line + "\n")
            self._process.stdin.flush()
        answer: dict[str, Any] = json.loads(self._answer())
        if "error" in answer:
            raise ValueError(answer["error"])
        return answer

    def _answer(self) -> str:
        line = self._process.stdout.readline() if self._process.stdout is not None else ""
        if not line:
            raise RigError("the emulated board ended unexpectedly")
        return line.strip()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()
