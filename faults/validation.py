"""Describe errors in the content of a file, with the line and key of each.

This module handles pydantic's errors without importing pydantic, which is slow.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, get_args

from slipscale.faults import UserError
from slipscale.faults.message import Message, joined
from slipscale.faults.suggestions import nearest
from slipscale.faults.toml_lines import Place

if TYPE_CHECKING:
    from pydantic import ValidationError

# Position of an error, and a record of the error as in pydantic, with "msg" and perhaps "input".
Fault = tuple[Place, dict[str, Any]]

# Message for users for each type of pydantic error, with placeholders.
SENTENCES = {
    "extra_forbidden": "unknown key",
    "missing": "is missing",
    "model_type": "expected a table",
    "dict_type": "expected a table",
    "tuple_type": "expected a list in [brackets]",
    "list_type": "expected a list in [brackets]",
    "string_type": 'expected words in "quotes"',
    "bool_type": "expected true or false",
    "bool_parsing": "expected true or false",
    "int_type": "expected a whole number",
    "int_parsing": "expected a whole number",
    "int_from_float": "expected a whole number",
    "float_type": "expected a number",
    "float_parsing": "expected a number",
    "finite_number": "expected a finite number",
    "date_type": "expected a date, such as 2026-11-22",
    "date_from_datetime_parsing": "expected a date, such as 2026-11-22",
    "greater_than": "expected a number above {gt}",
    "greater_than_equal": "expected {ge} or more",
    "less_than": "expected a number below {lt}",
    "less_than_equal": "expected {le} or less",
    "too_short": "expected at least {min_length} items, not {actual_length}",
    "too_long": "expected at most {max_length} items, not {actual_length}",
    "string_too_short": "expected at least {min_length} characters",
    "string_too_long": "expected at most {max_length} characters",
    "string_pattern_mismatch": "expected letters, digits and _, beginning with a letter",
    "literal_error": "expected {expected}",
    "value_error": "{error}",
}
# Message for all other types of errors.
OTHER = "expected another value"
NUMBERS = ("int_type", "float_type")
NUMBER = re.compile(r"\s*[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?\s*")
# Maximum number of characters of a wrong value in a message.
LONGEST_VALUE = 200


class Names(Protocol):
    """Interface for mapping the keys in a file to the field names of a model."""

    def in_file(self, place: Place) -> Place:
        """Replace the field names in an error's position with the keys used in the file."""

    def to_code(self, table: dict[str, object]) -> dict[str, object]:
        """Replace the keys of a file with the field names of the model."""


class Faults(ValueError):
    """Several faults at different positions, raised together by a pydantic validator."""

    def __init__(self, faults: list[Fault], *, within: bool = False) -> None:
        super().__init__("; ".join(fault["msg"] for _, fault in faults))
        self.faults = faults
        self.within = within


def in_words(error: ValidationError) -> str:
    """Describe pydantic's errors in one line, for input that is not a file."""
    return joined("; ", (each.whole for each in sentences(faults_in(error), lambda _: 0)))


def refuse(faults: Iterable[Fault], *, within: bool = False) -> None:
    """Raise one `Faults` exception for all faults; do nothing if there are none.

    If ``within``, the positions of the faults are relative to the table that is being validated.
    """
    if found := list(faults):
        raise Faults(found, within=within)


def faults_in(error: ValidationError, model: Any = None, names: Names | None = None) -> list[Fault]:
    """Convert pydantic's errors to faults, one for each position at which an error occurs.

    Parameters
    ----------
    error : ValidationError
    model : type, optional
        Pydantic model of the data. The model's keys are suggested as corrections for misspelt keys.
        A key is not reported as missing if a misspelling of this key is reported.
    names : Names, optional
        Names of keys in the file, if they differ from the model's fields.
    """
    in_file: Callable[[Place], Place] = names.in_file if names else tuple
    found: list[Fault] = []
    for each in error.errors():
        inner = each.get("ctx", {}).get("error")
        if isinstance(inner, Faults):
            table = each["loc"] if inner.within else ()
            found += [((*table, *place), fault) for place, fault in inner.faults]
        else:
            found.append((each["loc"], dict(each)))
    # If a value has several possible types, pydantic adds the type to the position: dict[str, str].
    found = [
        (in_file(tuple(part for part in place if "[" not in str(part))), fault)
        for place, fault in found
    ]
    meant: set[Place] = set()
    for place, fault in found:
        if fault.get("type") != "extra_forbidden" or "meant" in fault:
            continue
        keys = [in_file((*place[:-1], key))[-1] for key in _keys(model, place[:-1])]
        if key := nearest(place[-1], list(map(str, keys))):
            fault["meant"] = key
            meant.add((*place[:-1], key))
    return [each for each in found if not _follows(each, found, meant)]


def _follows(fault: Fault, found: list[Fault], meant: set[Place]) -> bool:
    """Return whether a fault is only a consequence of another fault in ``found``."""
    place, kind = fault[0], fault[1].get("type")
    if kind == "too_short":
        return any(other != place and other[: len(place)] == place for other, _ in found)
    if str(kind).endswith("_type"):
        # Any other error shows that the value has another of the possible types.
        others = (str(other.get("type")) for at, other in found if at == place)
        return not all(other.endswith("_type") for other in others)
    return kind == "missing" and place in meant


def _keys(model: Any, place: Place) -> list[str]:
    """Return the keys defined for the table at a position in a model, or an empty list."""
    for key in place:
        if model is not None and isinstance(key, str):
            field = getattr(model, "model_fields", {}).get(key)
            model = _model_in(field.annotation) if field else None
    return list(getattr(model, "model_fields", {}))


def _model_in(annotation: object) -> object:
    """Return the model contained in an annotation such as ``tuple[Model, ...] | None``, if any."""
    if hasattr(annotation, "model_fields"):
        return annotation
    return next(filter(None, map(_model_in, get_args(annotation))), None)


class Told(NamedTuple):
    """Fault of a file, for readers: line (0 if unknown), position, message, and all of it."""

    line: int
    place: Place
    message: str
    whole: str
    kind: str = ""  # pydantic's type of the error


class Complaint(UserError):
    """Error about the content of a file, with its ``faults`` as data."""

    faults: tuple[Told, ...] = ()


def fault_at(line: int, place: Place, message: str, kind: str = "") -> Told:
    """Return a fault whose whole text also contains the line and the key."""
    values = {"line": line, "key": place_in_words(place), "message": message}
    template = {
        (True, True): "line {line}, {key}: {message}",
        (True, False): "line {line}, {message}",
        (False, True): "{key}: {message}",
        (False, False): "{message}",
    }[bool(line), bool(place)]
    return Told(line, place, message, Message(template, **values), kind)


def sentences(faults: Iterable[Fault], line_of: Callable[[Place], int]) -> list[Told]:
    """Return all faults for readers, sorted by line."""
    found = [
        fault_at(line_of(place), place, _message(fault), fault.get("type", ""))
        for place, fault in faults
    ]
    return sorted(found, key=_in_order)


def _in_order(fault: Told) -> tuple[int, str]:
    return fault.line, fault.whole


def complaint(source: str, told: Iterable[Told]) -> Complaint:
    """Return an error that lists all faults in a file, sorted by line and without duplicates."""
    faults = sorted({each.whole: each for each in told}.values(), key=_in_order)
    if len(faults) == 1:
        error = Complaint("{source}: {fault}", source=source, fault=faults[0].whole)
    else:
        error = Complaint(
            "{source} has {count} faults:\n  {faults}",
            source=source,
            count=len(faults),
            faults=joined("\n  ", (each.whole for each in faults)),
        )
    error.faults = tuple(faults)
    return error


def _message(fault: dict[str, Any]) -> str:
    kind, known = fault.get("type", ""), fault.get("ctx", {})
    message: str = fault.get("msg", "")
    if kind:
        bounds = {
            key: f"{each:g}" if isinstance(each, float) else each for key, each in known.items()
        }
        message = Message(SENTENCES.get(kind, OTHER), **bounds)
    given = fault.get("input")
    if kind in NUMBERS and isinstance(given, str) and NUMBER.fullmatch(given):
        message = Message("{message} without quotation marks", message=message)
    if kind not in ("extra_forbidden", "missing") and isinstance(given, str | int | float):
        message = Message("{message}, got {entry}", message=message, entry=_shown(given))
    if kind == "literal_error":
        meant = nearest(given, re.findall("'([^']*)'", known["expected"]))
    else:
        meant = fault.get("meant")
    if meant:
        message = Message("{message} (did you mean '{meant}'?)", message=message, meant=meant)
    return message


def place_in_words(place: Place) -> str:
    """Format a position in a file as text.

    >>> place_in_words(("plate", "amplitude_um_pp")), place_in_words(("tasks", 0, "steps", 1))
    ('plate.amplitude_um_pp', 'item 2 of steps of item 1 of tasks')
    """
    words = ""
    for part in place:
        if isinstance(part, int):
            words = (
                Message("item {part} of {words}", part=part + 1, words=words)
                if words
                else Message("item {part}", part=part + 1)
            )
        elif words.startswith("item "):
            words = Message("{part} of {words}", part=part, words=words)
        else:
            words = f"{words}.{part}" if words else part
    return words


def _shown(value: float | str) -> str:
    whole = repr(value)
    return whole if len(whole) <= LONGEST_VALUE else f"{whole[:LONGEST_VALUE]} ..."
