"""Convert results to JSON.

By default, the keys of an object are its field names. A class whose keys differ from its field
names defines a method ``json_form`` that returns the keys in order. Rules for all classes:

- amplitudes are written as ``0.5`` if they are keys; NaN is written as null;
- field names of result classes (except keys of the class `Unchanged`), and strings of the class
  `OurName`, are converted to names for the stimulus quantity of the data;
- keys of plain mappings are not converted, because they are names of participants, files or
  groups, or names chosen by another package.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Protocol, TypeAlias, TypeGuard

import numpy as np

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Json: TypeAlias = "dict[str, Json] | list[Json] | str | float | int | bool | None"
JsonObject: TypeAlias = dict[str, Json]


class HasJsonForm(Protocol):
    """A result whose JSON keys differ from its field names."""

    def json_form(self) -> object:
        """Return the dictionary or other value that represents the result in JSON."""
        ...


class Unchanged(str):
    """A key that is not converted, such as ``levels`` for the levels of a factor."""

    __slots__ = ()


class OurName(str):
    """Field names used by Slipscale, separated by spaces."""

    __slots__ = ()


def text(value: object, named: Callable[[str], str] = str) -> str:
    """Convert a result to JSON text. See `form` for the parameter ``named``."""
    return json.dumps(form(value, named), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def form(value: object, named: Callable[[str], str] = str) -> Json:
    """Convert a result to values that JSON supports.

    Parameters
    ----------
    named : callable
        Function that returns the JSON key for a field name, such as
        `slipscale.stimuli.quantity.Quantity.named`.

    Raises
    ------
    TypeError
        If the value is not a result, mapping, sequence, string, number or None.

    Examples
    --------
    >>> form({0.5: (1.0, float("nan"))})
    {'0.5': [1.0, None]}
    """
    if isinstance(value, np.generic):
        return form(value.item())
    if isinstance(value, OurName):
        return " ".join(map(named, value.split(" ")))
    # Checked before `json_form`, because looking up a method of a million numbers is slow.
    if value is None or isinstance(value, str | int | float):
        return None if isinstance(value, float) and not math.isfinite(value) else value
    if _has_json_form(value):
        found = value.json_form()
        if not isinstance(found, Mapping):
            return form(found, named)
        value = _named(found, named)
    elif is_dataclass(value) and not isinstance(value, type):
        value = _named(renamed(value), named)
    if isinstance(value, Mapping):
        return {
            f"{key:g}" if isinstance(key, float) else str(key): form(inner, named)
            for key, inner in value.items()
        }
    if isinstance(value, list | tuple):
        return [form(inner, named) for inner in value]
    raise TypeError(f"{type(value).__name__}: not a result")


def _named(record: Mapping[str, object], named: Callable[[str], str]) -> dict[str, object]:
    return {
        name if isinstance(name, Unchanged) else named(name): inner
        for name, inner in record.items()
    }


def _has_json_form(value: object) -> TypeGuard[HasJsonForm]:
    # `isinstance` with a protocol takes a hundred times as long.
    return hasattr(value, "json_form")


def record(value: object) -> JsonObject:
    """Convert a result to a JSON object; raise TypeError if it becomes a list or a plain value."""
    found = form(value)
    if not isinstance(found, dict):
        raise TypeError(f"{type(value).__name__}: has no keys")
    return found


def renamed(value: DataclassInstance, **names: str) -> dict[str, object]:
    """Return an object's fields as a dictionary with renamed keys.

    A field is omitted if its new name is empty.
    """
    found = {names.get(each.name, each.name): getattr(value, each.name) for each in fields(value)}
    found.pop("", None)
    return found


def bounds(interval: object | None) -> object:
    """Return the interval, or a pair of None if there is no interval."""
    return (None, None) if interval is None else interval
