"""Try inputs one by one, and record those that are neither used nor rejected with a message.

Each input depends only on its kind and number, so that it can be reproduced.
"""

from __future__ import annotations

import random
import time
import traceback
from collections.abc import Callable, Iterable
from contextlib import ExitStack, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING

from tools.fuzzing.bounds import MOST_S, TooLong, limited_memory, limited_time
from tools.torture.pilots import folder

if TYPE_CHECKING:
    from tools.fuzzing.kind import Case, Kind

KINDS = (
    *("study_files", "journals", "data_sets", "tables_by_hand", "calibrations", "plate_files"),
    *("published_tables", "code_books", "laboratory_files", "column_meanings"),
)
# Memory is limited after this number of inputs, because the first inputs trigger lazy imports.
WARMING = 40


@dataclass(frozen=True, slots=True, kw_only=True)
class Find:
    """Input that was neither used nor rejected with an error message.

    Parameters
    ----------
    kind, number : str, int
        Identify the input.
    what : str
        Error, and the position at which it was raised.
    """

    kind: str
    number: int
    what: str


@dataclass(slots=True)
class Outcome:
    """Number of inputs tried and used, longest processor time, and failures."""

    tried: int = 0
    used: int = 0
    longest_s: float = 0.0
    finds: list[Find] = field(default_factory=list)


def kind_of(name: str) -> Kind:
    """Return a kind by the name of its module."""
    kind: Kind = import_module(f"tools.fuzzing.{name}").KIND
    return kind


def case(draw: Callable[[random.Random], Case], name: str, number: int) -> Case:
    """Return the input with this number."""
    return draw(random.Random(f"{name} {number}"))


def tried(name: str, numbers: Iterable[int]) -> Outcome:
    """Try inputs, each within 2 s of processor time, together within 500 MB of memory."""
    outcome = Outcome()
    with ExitStack() as stack:
        draw = kind_of(name).prepared(stack.enter_context(folder()))
        silent = (redirect_stdout(StringIO()), redirect_stderr(StringIO()))
        for count, number in enumerate(numbers):
            if count == WARMING:
                stack.enter_context(limited_memory())
            with silent[0], silent[1]:
                _try(outcome, draw, name, number)
    return outcome


def _try(outcome: Outcome, draw: Callable[[random.Random], Case], name: str, number: int) -> None:
    text = case(draw, name, number)
    began_s = time.process_time()
    outcome.tried += 1
    try:
        with limited_time():
            outcome.used += text.use()
    except TooLong:
        what = f"more than {MOST_S:g} s of processor time"
        outcome.finds.append(Find(kind=name, number=number, what=what))
    except Exception as error:  # noqa: BLE001 - any exception is a failure
        outcome.finds.append(Find(kind=name, number=number, what=_said(error)))
    outcome.longest_s = max(outcome.longest_s, time.process_time() - began_s)


def _said(error: Exception) -> str:
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if "/.venv/" not in frame.filename
    ]
    last = frames[-1]
    place = f"{Path(last.filename).name}:{last.lineno} in {last.name}"
    return f"{type(error).__name__} at {place}: {str(error)[:200]}"
