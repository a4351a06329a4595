"""Questions at the terminal while a plate vibrates: something keeps it alive while a person types.

A board silences itself when it hears nothing for its watchdog's time. While `typed` waits, a thread
asks the board again and again; nobody else may use the line meanwhile.
"""

from __future__ import annotations

import sys
from threading import Event, Thread
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

ALIVE_S = 0.1


def typed(question: str, alive: Callable[[], object], *, every_s: float = ALIVE_S) -> str:
    """Return the line that a person types; call ``alive`` every 0.1 s until then.

    The question is printed before the first call, so that whoever waits for it can answer at once.

    Raises
    ------
    EOFError
        Standard input has ended.
    Exception
        The first that ``alive`` raised, once the person has typed.
    """
    over, faults = Event(), list[Exception]()

    def keep() -> None:
        while not over.wait(every_s):
            try:
                alive()
            except Exception as fault:  # noqa: BLE001 - raised below, in the caller's thread
                faults.append(fault)
                return

    keeper = Thread(target=keep, name="keep alive", daemon=True)
    keeper.start()
    try:
        print(question, end="", flush=True)
        line = sys.stdin.readline()
    finally:
        over.set()
        keeper.join()
    if faults:
        raise faults[0]
    if not line:
        raise EOFError
    return line.rstrip("\n")
