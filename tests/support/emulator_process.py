"""An emulated board in a separate process, for rehearsals and tests in real time."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any, Self

from slipscale.faults import RigError
from tests.support.controlled_board import ControlledBoard


class EmulatorProcess(ControlledBoard):
    """Run ``slipscale plate emulate`` within a ``with`` block.

    Parameters
    ----------
    *arguments : str
        Arguments of ``slipscale plate emulate``.
    """

    def __init__(self, *arguments: str) -> None:
        command = [sys.executable, "-m", "slipscale", "plate", "emulate", *arguments]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.port = self._line()

    @property
    def process_id(self) -> int:
        """Process id."""
        return self._process.pid

    def close(self) -> None:
        """End the process."""
        self._process.terminate()
        self._process.communicate()

    def _answer_to(self, line: str) -> dict[str, Any]:
        if self._process.stdin is not None:
            self._process.stdin.write(line + "\n")
            self._process.stdin.flush()
        answer: dict[str, Any] = json.loads(self._line())
        return answer

    def _line(self) -> str:
        line = self._process.stdout.readline() if self._process.stdout is not None else ""
        if not line:
            raise RigError("the emulated board ended unexpectedly")
        return line.strip()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()
