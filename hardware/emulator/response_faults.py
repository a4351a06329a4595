"""How an emulated board can misbehave: each fault turns one answer into what is sent instead.

A plan is a list of pieces: bytes to send, seconds to wait, or something to do to the board. The
emulator's loop carries it out; nothing here knows a port or a clock.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

LATE_S = 0.12  # later than a host waits for one answer
TRICKLE_S = 0.02  # a byte
GARBAGE = b"\x00\xff#\x7f<7 \xc3("


class Act(Enum):
    """Something done to the board or its line, besides sending."""

    UNPLUG = auto()
    RESET = auto()
    STICK = auto()  # answer every command with "busy" from now
    HEAT = auto()
    DEAFEN = auto()  # answer nothing from now


Piece = bytes | float | Act


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer that was due, and the one before it."""

    reply: bytes
    previous: bytes


def _trickle(answer: Answer) -> list[Piece]:
    pieces: list[Piece] = []
    for byte in answer.reply:
        pieces += [bytes([byte]), TRICKLE_S]
    return pieces


def _halves(answer: Answer) -> tuple[bytes, bytes]:
    middle = len(answer.reply) // 2
    return answer.reply[:middle], answer.reply[middle:]


# Faults that let the command run and spoil its answer.
SPOILS: dict[str, Callable[[Answer], list[Piece]]] = {
    "drop": lambda _: [],
    "unplug_mid_read": lambda answer: [_halves(answer)[0], Act.UNPLUG],
    "garbage_before": lambda answer: [GARBAGE + answer.reply],
    "garbage_inside": lambda answer: [GARBAGE.join(_halves(answer))],
    "garbage_after": lambda answer: [answer.reply + GARBAGE],
    "garbage_line": lambda answer: [GARBAGE + b"\n" + answer.reply],
    "truncated": lambda answer: [_halves(answer)[0]],
    "delayed": lambda answer: [LATE_S, answer.reply],
    "duplicated": lambda answer: [answer.reply + answer.reply],
    "out_of_order": lambda answer: [answer.previous + answer.reply],
    "trickle": _trickle,
    "reset_after": lambda answer: [answer.reply, Act.RESET],
}

# Faults that strike before the command is heard.
STRIKES: dict[str, Act] = {
    "unplug": Act.UNPLUG,
    "reset": Act.RESET,
    "busy": Act.STICK,
    "hot": Act.HEAT,
    "deaf": Act.DEAFEN,
}

FATAL = (Act.UNPLUG, Act.RESET, Act.DEAFEN)  # the command is not heard any more

# Faults of the whole run.
STANDING = ("wrong_identity", "nmea", "old_firmware")

FAULT_NAMES = (*SPOILS, *STRIKES, *STANDING)

# Phases of a trial: the commands that belong to each.
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
