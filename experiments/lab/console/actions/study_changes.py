"""Apply changes from the editor's form to the text of a study file, and keep its comments.

The functions return the new text, and do not write files. If the form cannot make a change, for
example because the text is not TOML, the user must edit the file itself.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from typing import Annotated, Any, Literal

from pydantic import Field

from slipscale.experiments.lab.console.actions.forms import LARGEST_STUDY, Form
from slipscale.faults import UserError
from slipscale.faults.toml_file import toml_table

Kind = Literal["text", "number", "switch", "choice", "numbers", "lines", "several"]
Key = Annotated[str, Field(max_length=200)] | Annotated[int, Field(ge=0, lt=10_000)]
NUMBER = re.compile(r"[-+]?\d+([.,]\d+)?(e[-+]?\d+)?", re.IGNORECASE)
SOURCE = "the study file"


class Change(Form):
    """A single change requested by the form.

    Parameters
    ----------
    what : str
        The kind of change: set a value (an empty value removes the key), add or remove a table or
        an item, or move an item.
    place : tuple
        Position in the study file, as a path of keys and of array indices (from 0).
    kind : str
        Input type of the form field, which determines the type of ``value``.
    value : str
        New value for a field, protocol for a new task, or key for a new entry.
    to : int
        Index at which a moved item is inserted.
    """

    what: Literal["set", "add", "item", "entry", "remove", "move"]
    place: Annotated[tuple[Key, ...], Field(min_length=1, max_length=20)]
    kind: Kind = "text"
    value: Annotated[str, Field(max_length=LARGEST_STUDY)] = ""
    to: Annotated[int, Field(ge=0, lt=10_000)] = 0


class Edit(Form):
    """The study's text as sent by the page, and the requested change.

    Parameters
    ----------
    text : str
    template : str
        Shipped study on which the text is based; empty if the text is the folder's own study.
    change : Change, optional
    """

    text: Annotated[str, Field(max_length=LARGEST_STUDY)]
    template: Annotated[str, Field(max_length=100)] = ""
    change: Change | None = None


def changed(text: str, change: Change) -> str:
    """Apply a change to the text of a study file; return the new text.

    Raises
    ------
    UserError
        If the text is not TOML, if the text does not contain the position of the change, or if
        the change is not possible in this text.
    """
    import tomlkit

    toml_table(text, SOURCE)
    document = tomlkit.parse(text)
    made: dict[str, Callable[[Any, Any], None]] = {
        "set": lambda table, key: _set(table, key, change),
        "add": lambda table, key: _put(table, key, tomlkit.table()),
        "item": lambda table, key: _append(table, key, change.value),
        "entry": lambda table, key: _enter(table[key], change.value),
        "remove": lambda table, key: table.pop(key),
        "move": lambda items, at: items.insert(change.to, items.pop(at)),
    }
    try:
        container, last = _container(document, change.place[:-1], change), change.place[-1]
        if change.what == "remove" and isinstance(last, int) and len(container) == 1:
            # An array of tables cannot be empty in TOML.
            container, last = _container(document, change.place[:-2], change), change.place[-2]
        made[change.what](container, last)
        after = tomlkit.dumps(document)
        kept = tomllib.loads(after) == document.unwrap()
    except (KeyError, IndexError, TypeError, ValueError, AttributeError):
        kept = False
    if not kept:
        raise UserError(
            "{source}: the form cannot make this change in a file written this way; edit the "
            "file as text",
            source=SOURCE,
        )
    return after


def value_of(kind: Kind, typed: str) -> Any:
    """Convert typed text to a TOML value; leave invalid numbers as text.

    A comma in a number is its decimal mark if the numbers are separated by semicolons or blanks.
    After a comma with a blank ("0, 0,8") it could be either, so that it stays text.

    >>> value_of("number", "0,5"), value_of("numbers", "0; 0,8; 1,9"), value_of("number", "many")
    (0.5, [0, 0.8, 1.9], 'many')
    >>> value_of("numbers", "0,1.5,2"), value_of("numbers", "0 0,8"), value_of("numbers", "0, 0,8")
    ([0, 1.5, 2], [0, 0.8], [0, '0,8'])
    """
    if kind == "switch":
        return typed == "true"
    if kind == "several":
        return [word for word in re.split(r"[\s,;]+", typed) if word]
    if kind == "numbers":
        return _numbers(typed)
    if kind == "lines":
        return [line.strip() for line in typed.splitlines() if line.strip()]
    if kind == "number" or (kind == "choice" and typed.isdecimal()):
        return _number(typed.strip())
    return typed


def _numbers(typed: str) -> list[int | float | str]:
    separators = r"\s*;\s*" if ";" in typed else r",\s+" if re.search(r",\s", typed) else r"\s+"
    parts = [part for part in re.split(separators, typed.strip()) if part]
    if len(parts) == 1:
        return [_number(word) for word in parts[0].split(",") if word]
    unclear = separators.startswith(",")
    return [part if unclear and "," in part else _number(part) for part in parts]


def _number(typed: str) -> int | float | str:
    if not NUMBER.fullmatch(typed):
        return typed
    plain = typed.replace(",", ".")
    return int(plain) if re.fullmatch(r"[-+]?\d+", plain) else float(plain)


def _container(document: Any, place: tuple[Key, ...], change: Change) -> Any:
    """Return the table or array at a position; create missing tables for a new value."""
    import tomlkit

    for part in place:
        if change.what in ("set", "add", "item") and isinstance(part, str) and part not in document:
            document[part] = tomlkit.table()
        document = document[part]
    return document


def _set(table: Any, key: Any, change: Change) -> None:
    if change.value or change.kind == "switch":
        table[key] = value_of(change.kind, change.value)
    elif key in table:
        del table[key]


def _put(table: Any, key: Any, value: Any) -> None:
    if key not in table:
        table[key] = value


def _append(table: Any, key: Any, protocol: str) -> None:
    """Append an item to an array of tables, which is created if necessary."""
    import tomlkit

    item = tomlkit.table()
    if protocol:
        item["protocol"] = protocol
    _put(table, key, tomlkit.aot())
    table[key].append(item)


def _enter(table: Any, key: str) -> None:
    """Add an entry whose text is its key, in the same languages as the table's last entry."""
    if not key.strip() or key in table:
        raise ValueError(key)
    last = list(table.values())[-1] if table else ""
    table[key] = dict.fromkeys(last, key) if isinstance(last, dict) else key
