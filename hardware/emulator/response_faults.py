"""Define the faults of an emulated board.

A fault that affects answers is a function: for each correct answer, it returns the steps that
replace the answer (bytes to send, seconds to wait, or actions on the board). The emulator executes
the steps in order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto

LATE_S = 0.12  # delay of an answer, longer than a host waits for one answer
# Time to send an answer byte by byte: longer than a host waits for one answer, but shorter than it
# waits for a starting board.
TRICKLE_S = 1.5
GARBAGE = b"\x00\xff#\x7f<7 \xc3("


class BoardAction(Enum):
    """Effect of a fault on the board or the serial line, such as unplugging the board."""

    UNPLUG = auto()
    RESET = auto()
    BUSY = auto()  # Answer all following commands with "busy".
    HOT = auto()
    DEAFEN = auto()  # Do not answer any following commands.


Piece = bytes | float | BoardAction


@dataclass(frozen=True, slots=True)
class Answer:
    """Correct answer to a command, and the answer to the previous command."""

    reply: bytes
    previous: bytes


def _trickle(answer: Answer) -> list[Piece]:
    pieces: list[Piece] = []
    for byte in answer.reply:
        pieces += [bytes([byte]), TRICKLE_S / len(answer.reply)]
    return pieces


def _halves(answer: Answer) -> tuple[bytes, bytes]:
    middle = len(answer.reply) // 2
    return answer.reply[:middle], answer.reply[middle:]


# Faults in which the command is executed but its answer is lost, late or damaged.
ANSWER_FAULTS: dict[str, Callable[[Answer], list[Piece]]] = {
    "drop": lambda _: [],
    "unplug_mid_read": lambda answer: [_halves(answer)[0], BoardAction.UNPLUG],
    "garbage_before": lambda answer: [GARBAGE + answer.reply],
    "garbage_inside": lambda answer: [GARBAGE.join(_halves(answer))],
    "garbage_after": lambda answer: [answer.reply + GARBAGE],
    "garbage_line": lambda answer: [GARBAGE + b"\n" + answer.reply],
    "truncated": lambda answer: [_halves(answer)[0]],
    "delayed": lambda answer: [LATE_S, answer.reply],
    "duplicated": lambda answer: [answer.reply + answer.reply],
    "out_of_order": lambda answer: [answer.previous + answer.reply],
    "trickle": _trickle,
    "reset_after": lambda answer: [answer.reply, BoardAction.RESET],
}

# Faults that begin when a command arrives, before the board processes it.
COMMAND_FAULTS: dict[str, BoardAction] = {
    "unplug": BoardAction.UNPLUG,
    "reset": BoardAction.RESET,
    "busy": BoardAction.BUSY,
    "hot": BoardAction.HOT,
    "deaf": BoardAction.DEAFEN,
}

UNHEARD = (
    BoardAction.UNPLUG,
    BoardAction.RESET,
    BoardAction.DEAFEN,
)  # the command is not received

# Faults that last for the whole run.
RUN_FAULTS = ("wrong_identity", "nmea", "old_firmware")

# Faults that only the board emulated in Python supports: the compiled firmware is never busy and
# has a fixed identity.
EMULATED_ONLY = ("busy", "wrong_identity", "old_firmware")

FAULT_NAMES = (*ANSWER_FAULTS, *COMMAND_FAULTS, *RUN_FAULTS)

# Phases of a trial, with the commands that belong to each phase.
PHASES: dict[str, tuple[str, ...]] = {
    "connect": ("*IDN?", "*RST", "LIM?", "LIST:LIM?"),
    "present": ("AMPL", "DRIV"),
    "play": ("LIST:AMPL", "LIST:PLAY"),
    "read": ("STAT?",),
    "silence": ("OUTP",),
}


def phase_of(header: str) -> str:
    """Return the phase to which a command belongs, or "other".

    >>> phase_of("AMPL")
    'present'
    """
    return next((phase for phase, headers in PHASES.items() if header in headers), "other")
