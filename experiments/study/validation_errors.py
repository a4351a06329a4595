"""Faults of a study file: where each is, and the sentence that says so."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable

# Where in the file: keys, and numbers in arrays, from 0.
Place = tuple[str | int, ...]
# A fault's place, and pydantic's record of it or one alike: "msg" and, where known, "input".
Fault = tuple[Place, dict[str, Any]]


# What pydantic says in Python's words, in those of a study file.
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


class Faults(ValueError):
    """Several faults, each with its place: pydantic would take them for one."""

    def __init__(self, faults: list[Fault]) -> None:
        super().__init__("; ".join(fault["msg"] for _, fault in faults))
        self.faults = faults


def refuse(faults: Iterable[Fault]) -> None:
    """Raise all faults there are."""
    if found := list(faults):
        raise Faults(found)


def sentence(text: str, place: Place, fault: dict[str, Any]) -> tuple[int, str]:
    """Return a fault's line (0: none) and the sentence about it."""
    where = ".".join(str(part + 1) if isinstance(part, int) else part for part in place)
    kind = fault.get("type", "")
    message = SENTENCES.get(kind) or fault["msg"].removeprefix("Value error, ")
    told = kind in ("extra_forbidden", "missing")
    if not told and isinstance(fault.get("input"), str | int | float):
        message = f"{message[0].lower()}{message[1:]}, got {fault['input']!r}"
    line = line_of(text, place)
    spot = f"line {line}, " if line else ""
    return line, f"{spot}{where}: {message}" if where else f"{spot}{message}"


def line_of(text: str, place: Place) -> int:
    r"""Return the line in a TOML text where a key stands, or its table, or 0.

    >>> line_of("a = 1\n[[tasks]]\nb = 2", ("tasks", 0, "b"))
    3
    """
    seen: dict[str, int] = {}
    table: Place = ()
    nearest = 0
    in_string = False
    for number, line in enumerate(text.splitlines(), start=1):
        was_in_string = in_string
        in_string ^= (line.count('"""') + line.count("'''")) % 2 == 1
        if was_in_string:
            continue
        if header := re.match(r"\s*\[(\[?)\s*([\w.\-]+)\s*\]", line):
            name = header[2]
            seen[name] = seen.get(name, -1) + 1
            table = (*name.split("."), *([seen[name]] if header[1] else []))
            if table == place[: len(table)]:
                nearest = number
            whole = table
        elif key := re.match(r"\s*([\w\-.]+)\s*=", line):
            whole = (*table, *key[1].split("."))
            if whole == place[: len(whole)]:
                return number
        else:
            continue
        if not nearest and whole[: len(place)] == place:
            nearest = number  # the first key or table below that place
    return nearest
