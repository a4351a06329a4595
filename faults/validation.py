"""Faults of a file's content: where each is, and the sentence that says so.

Takes what pydantic found, but does not load it: whoever has an error of it has loaded it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from slipscale.faults import UserError
from slipscale.faults.toml_lines import Place

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from pydantic import ValidationError

# A fault's place, and pydantic's record of it or one alike: "msg" and, where known, "input".
Fault = tuple[Place, dict[str, Any]]

# What pydantic says in Python's words, in those of a file.
SENTENCES = {
    "extra_forbidden": "there is no such key",
    "missing": "is missing",
    "model_type": "expected a table",
    "dict_type": "expected a table",
    "tuple_type": "expected a list in [brackets]",
    "string_type": 'expected words in "quotes"',
    "bool_type": "expected true or false",
    "string_pattern_mismatch": "expected letters, digits and _, beginning with a letter",
}
# Characters of a wrong value that a message repeats.
LONGEST_VALUE = 200


class Faults(ValueError):
    """Several faults, each with its place: pydantic would take them for one."""

    def __init__(self, faults: list[Fault]) -> None:
        super().__init__("; ".join(fault["msg"] for _, fault in faults))
        self.faults = faults


def refuse(faults: Iterable[Fault]) -> None:
    """Raise all faults there are."""
    if found := list(faults):
        raise Faults(found)


def faults_in(error: ValidationError) -> list[Fault]:
    """Return the faults that pydantic found, those with places of their own one by one."""
    found: list[Fault] = []
    for fault in error.errors():
        inner = fault.get("ctx", {}).get("error")
        found += inner.faults if isinstance(inner, Faults) else [(fault["loc"], dict(fault))]
    return found


def sentences(faults: Iterable[Fault], line_of: Callable[[Place], int]) -> list[tuple[int, str]]:
    """Return each fault's line (0: none) and the sentence about it, in the order of the lines."""
    found = []
    for place, fault in faults:
        line = line_of(place)
        found.append((line, _sentence(line, place, fault)))
    return sorted(found)


def complaint(source: str, told: Iterable[tuple[int, str]]) -> UserError:
    """Return the error that tells every fault of a file once, in the order of their lines.

    Parameters
    ----------
    source : str
        The file's name.
    told : iterable of (int, str)
        One or more, as `sentences` gives them.
    """
    lines = sorted(set(told))
    many = "a fault" if len(lines) == 1 else f"{len(lines)} faults"
    return UserError(f"{source} has {many}:" + "".join(f"\n  {words}" for _, words in lines))


def _sentence(line: int, place: Place, fault: dict[str, Any]) -> str:
    """Return the sentence about a fault: line (0: none), key, what was expected and found."""
    where = ".".join(str(part + 1) if isinstance(part, int) else part for part in place)
    kind = fault.get("type", "")
    message = SENTENCES.get(kind) or fault["msg"].removeprefix("Value error, ")
    told = kind in ("extra_forbidden", "missing")
    if not told and isinstance(fault.get("input"), str | int | float):
        message = f"{message[0].lower()}{message[1:]}, got {_shown(fault['input'])}"
    spot = f"line {line}, " if line else ""
    return f"{spot}{where}: {message}" if where else f"{spot}{message}"


def _shown(value: float | str) -> str:
    """Return a value as a message shows it: all of it, if it is not too long."""
    whole = repr(value)
    return whole if len(whole) <= LONGEST_VALUE else f"{whole[:LONGEST_VALUE]} ..."
