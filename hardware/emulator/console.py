"""Run an emulated board that is controlled by standard input.

The port is printed first. Each line of input is answered with the new state as one line of JSON:

==================  ==============================================================
``state``           only report, see `Emulator.state`
``fault NAME``      at the next command; ``NAME@PHASE/N`` as with ``--fault``
``no faults``       remove pending faults
``unplug``          unplug the board now
``back``            plug in and restart the board now
``finger``          put a finger on the plate that reduces its Q from 60 to 50
``no finger``       remove the finger
``quit``            end (as SIGTERM does)
==================  ==============================================================
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING

from slipscale.hardware.plate.dynamics import FingerLoad

if TYPE_CHECKING:
    from slipscale.hardware.emulator.emulator import Emulator
    from slipscale.hardware.emulator.pty import PseudoTerminal

FINGER = FingerLoad(loss=1 / 300)  # reduces the plate's Q from 60 to 50

ACTS: dict[str, Callable[[Emulator], None]] = {
    "state": lambda _: None,
    "no faults": lambda emulator: emulator.cancel(),
    "unplug": lambda emulator: emulator.unplug(),
    "back": lambda emulator: emulator.come_back(),
    "finger": lambda emulator: emulator.touch(FINGER),
    "no finger": lambda emulator: emulator.touch(),
}


def run(emulator: Emulator, terminal: PseudoTerminal) -> None:
    """Print the name of the port, and emulate the board until interrupted."""
    print(terminal.port, flush=True)
    control: int | None = sys.stdin.fileno()
    buffer = b""
    try:
        while True:
            if not terminal.turn(emulator, control):
                continue
            data = os.read(sys.stdin.fileno(), 4096)
            if not data:
                control = None  # When standard input has ended, the emulation continues.
            *lines, buffer = (buffer + data).split(b"\n")
            for line in lines:
                if line.strip() == b"quit":
                    return
                print(answer(emulator, line.decode("utf-8", "replace").strip()), flush=True)
    finally:
        emulator.unplug()


def answer(emulator: Emulator, line: str) -> str:
    """Carry out a line of input, and return the answer as one line of JSON."""
    word, _, rest = line.partition(" ")
    try:
        if word == "fault":
            emulator.order(rest)
        elif line in ACTS:
            ACTS[line](emulator)
        else:
            return json.dumps(
                {
                    "error": (
                        f"unknown control line '{line}' (expected one of: fault NAME, quit, "
                        f"{', '.join(ACTS)})"
                    )
                }
            )
    except ValueError as error:
        return json.dumps({"error": str(error)})
    return json.dumps(emulator.state())
