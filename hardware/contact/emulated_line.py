"""Emulate a sensor that sends lines of numbers: two lasers, or load cells.

    python -m slipscale.hardware.contact.emulated_line [--rate 100]

This command prints the name of a pseudo-terminal, and sends the position and forces of a finger
that strokes back and forth: ``x,y,normal,lateral`` in mm and N. The same port can be used for
``--position lasers:PORT`` and for ``--force load_cells:PORT,normal=3,lateral=4``.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import tty
from collections.abc import Callable
from contextlib import suppress
from threading import Event, Thread
from typing import Self

STROKE_MM, STROKES_HZ = 40.0, 1.0  # back and forth
NORMAL_N, FRICTION = 0.5, 0.6


def stroking(time_s: float) -> bytes:
    """Return the line sent at a given time for a finger that strokes back and forth."""
    turn = 2 * math.pi * STROKES_HZ * time_s
    lateral = math.copysign(FRICTION * NORMAL_N, math.sin(turn))
    along = -STROKE_MM / 2 * math.cos(turn)
    return f"{along:.3f},0.000,{NORMAL_N:.4f},{lateral:.4f}\n".encode()


class EmulatedLine:
    """Context manager for a pseudo-terminal that sends lines (Unix only).

    Parameters
    ----------
    line : callable
        Function that takes the time since the start in seconds and returns the line to send.
    rate_hz : float
        Lines per second.

    Attributes
    ----------
    port : str
        Name of the port.
    sends : bool
        Whether to send lines.
    """

    def __init__(
        self, line: Callable[[float], bytes] = stroking, *, rate_hz: float = 100.0
    ) -> None:
        self._line = line
        self._rate_hz = rate_hz
        self._stop = Event()
        self._thread = Thread(target=self._run, name="emulated sensor", daemon=True)
        self.sends = True
        self._ours = self._theirs = -1  # ends of the pseudo-terminal
        self.port = ""

    def __enter__(self) -> Self:
        if sys.platform == "win32":  # where importing tty fails already; for the type checker
            raise NotImplementedError
        self._ours, self._theirs = os.openpty()
        tty.setraw(self._theirs)
        os.set_blocking(self._ours, False)  # Writing must not block if no program reads the port.
        self.port = os.ttyname(self._theirs)
        self._thread.start()
        return self

    def _run(self) -> None:
        number = 0
        while not self._stop.wait(1 / self._rate_hz):
            number += 1
            if self.sends:
                with suppress(BlockingIOError):
                    os.write(self._ours, self._line(number / self._rate_hz))

    def unplug(self) -> None:
        """Close the port, as if the device were unplugged."""
        self._stop.set()
        self._thread.join()
        for end in (self._ours, self._theirs):
            with suppress(OSError):
                os.close(end)

    def __exit__(self, *_error: object) -> None:
        self.unplug()


def main() -> int:
    """Send lines until standard input ends or Ctrl-C is pressed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--rate", type=float, default=100.0, help="lines a second (default: 100)")
    wanted = parser.parse_args()
    with EmulatedLine(rate_hz=wanted.rate) as line, suppress(KeyboardInterrupt):
        print(line.port, flush=True)
        sys.stdin.read()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
