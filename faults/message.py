"""Text that remembers the template and the values that it was written from.

A message is an English text, so it can be printed, sorted and compared. Its template is the key
under which a catalogue lists the translation, as in gettext; a text without values is its own
template. Because a message is a string (as in markupsafe), errors, findings and notices need no
further type, and nothing has to recognise a finished sentence to translate it.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Mapping
from numbers import Integral, Real
from typing import Self, cast

Value = str | int | float
# A message in JSON: its text, or its template and values.
Data = str | dict[str, object]


class Message(str):
    """English text written from a template with named placeholders.

    >>> found = Message("{path}: expected {count} rows", path="a.csv", count=3)
    >>> found, found.template, dict(found.values)
    ('a.csv: expected 3 rows', '{path}: expected {count} rows', {'path': 'a.csv', 'count': 3})

    Parameters
    ----------
    template : str
        Text with named placeholders, as for `str.format`. Without values, braces are text.
    **values
        Numbers, texts, messages or exceptions. Other objects are inserted as text.
    """

    __slots__ = ("template", "values")
    template: str
    values: Mapping[str, Value]

    def __new__(cls, template: str, /, **values: object) -> Self:
        """Write the text from its template and values."""
        if isinstance(template, cls):
            return template
        kept = {name: _value(each) for name, each in values.items()}
        message = super().__new__(cls, template.format(**kept) if kept else template)
        message.template, message.values = template, kept
        return message

    def __str__(self) -> str:
        # Unlike a plain string's method, this keeps the message in `str(error)`.
        return self

    def __reduce__(self) -> tuple[object, ...]:
        return from_data, (as_data(self),)


def _value(given: object) -> Value:
    if isinstance(given, str | int | float):
        return given
    if isinstance(given, Integral):
        return int(given)
    return float(given) if isinstance(given, Real) else str(given)


def joined(joint: str, parts: Iterable[str]) -> str:
    """Join texts with punctuation, which is a template of its own: ``{first}; {rest}``."""
    *firsts, text = [*parts] or [""]
    for first in reversed(firsts):
        text = Message(f"{{first}}{joint}{{rest}}", first=first, rest=text)
    return text


def as_data(text: str) -> Data:
    """Return a text for JSON: a message's template and values, or the text itself."""
    if not isinstance(text, Message) or not text.values:
        return str.__str__(text)
    values = {k: as_data(v) if isinstance(v, str) else v for k, v in text.values.items()}
    return {"template": text.template, "values": values}


# Environment variable with which the console starts commands: messages are written as data.
AS_DATA = "SLIPSCALE_MESSAGES_AS_DATA"


def output(text: str) -> Data:
    """Return a text for a command's JSON output: as data if the console started the command."""
    return as_data(text) if AS_DATA in os.environ else str.__str__(text)


def report(kind: str, message: str, line: str) -> None:
    """Print a line on standard error; write the message as JSON if the console reads it."""
    as_json = AS_DATA in os.environ
    print(json.dumps({kind: as_data(message)}) if as_json else line, file=sys.stderr)


def from_data(data: object) -> str:
    """Return the text that `as_data` converted; raise ValueError if it is damaged."""
    if not isinstance(data, dict):
        return str(data)
    try:
        given = cast("dict[str, object]", data["values"])
        values = {k: from_data(v) if isinstance(v, dict) else v for k, v in given.items()}
        return Message(str(data["template"]), **values)
    except (KeyError, AttributeError, IndexError, TypeError) as error:
        raise ValueError("expected the template and the values of a message") from error
