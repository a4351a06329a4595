"""Try texts of a kind one by one; record every result other than use or an error message.

Text number n of a kind depends only on the kind's name and n, so that it can be reproduced.
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
# The first texts trigger lazy imports; memory is limited after them.
WARMING = 40


@dataclass(frozen=True, slots=True, kw_only=True)
class Find:
    """A text that ended in something other than use or an error message.

    Parameters
    ----------
    kind, number : str, int
        Identify the text.
    what : str
        The error and where it was raised; the same for texts with one cause.
    """

    kind: str
    number: int
    what: str


@dataclass(slots=True)
class Outcome:
    """The results for texts of a kind: how many were tried and used, and the failures."""

    tried: int = 0
    used: int = 0
    longest_s: float = 0.0
    finds: list[Find] = field(default_factory=list)


def kind_of(name: str) -> Kind:
    """Return a kind by the name of its module."""
    kind: Kind = import_module(f"tools.fuzzing.{name}").KIND
    return kind


def case(draw: Callable[[random.Random], Case], name: str, number: int) -> Case:
    """Return the text of a kind with this number."""
    return draw(random.Random(f"{name} {number}"))


def tried(name: str, numbers: Iterable[int]) -> Outcome:
    """Try texts of a kind by number, each within 2 s of processor time, all within 500 MB."""
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
        what = f"more than {MOST_S:g} s of the processor"
        outcome.finds.append(Find(kind=name, number=number, what=what))
    except Exception as error:  # noqa: BLE001 - what is looked for
        outcome.finds.append(Find(kind=name, number=number, what=_said(error)))
    outcome.longest_s = max(outcome.longest_s, time.process_time() - began_s)


def _said(error: Exception) -> str:
    """Return an error's type, the position in our code where it was raised, and its message."""
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if "/.venv/" not in frame.filename
    ]
    last = frames[-1]
    place = f"{Path(last.filename).name}:{last.lineno} in {last.name}"
    return f"{type(error).__name__} at {place}: {str(error)[:200]}"
