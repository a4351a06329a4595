"""Record what a guard does, in place of an instrument; for tests and rehearsals."""

from __future__ import annotations

import time
from pathlib import Path


class GuardRecorder:
    """Switch that writes the time of each `switch_off` to a file.

    Parameters
    ----------
    path : str
        File to which lines are appended: the monotonic time in seconds.
    """

    def __init__(self, path: str) -> None:
        self._path = Path(path)

    def switch_off(self) -> None:
        """Record that the output was switched off."""
        with self._path.open("a", encoding="utf-8") as file:
            file.write(f"{time.monotonic()}\n")
