"""Find the line numbers of keys, tables and list items in a TOML document.

`tomllib` reports line numbers only for syntax errors. The functions of this module require a valid
document, because they find keys only by words and brackets.
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass, field

# Position in a file: keys, and list indices from 0.
Place = tuple[str | int, ...]

TOKEN = re.compile(
    r"""
    (?P<comment>\#[^\n]*)
  | (?P<long>\"{3}(?:\\.|[^\\])*?\"{3,5} | '{3}.*?'{3,5})
  | (?P<word>"(?:\\.|[^"\\\n])*" | '[^'\n]*' | [^\s\[\]{},=\#"'.]+)
  | (?P<sign>[\[\]{},=.\n])
    """,
    re.VERBOSE | re.DOTALL,
)


class Lines:
    r"""Line numbers of the entries in a valid TOML document.

    Examples
    --------
    >>> Lines("a = 1\n[[tasks]]\nb = [\n 2,\n 3]").of(("tasks", 0, "b", 1))
    5
    """

    def __init__(self, text: str) -> None:
        self._exact: dict[Place, int] = {}
        self._below: dict[Place, int] = {}
        for place, line in _Reader().places(text):
            self._exact.setdefault(place, line)
            for length in range(len(place)):
                self._below.setdefault(place[:length], line)

    def of(self, place: Place) -> int:
        """Return the line number of an entry, or 0 if it is unknown.

        An entry that does not appear in the document, such as a missing key, has the line of its
        table or of its first content.
        """
        for length in range(len(place), 0, -1):
            if place[:length] in self._exact:
                return self._exact[place[:length]]
        return self._below.get(place, 0) if place else 0


@dataclass(slots=True)
class _Value:
    """Unclosed list or inline table."""

    place: Place
    item: int | None = None  # index of the next item of a list


@dataclass(slots=True)
class _Reader:
    """Reader that processes tokens and keeps track of the current table, key and open brackets."""

    table: Place = ()
    last_item: dict[Place, int] = field(default_factory=dict)  # for each array of tables
    opened: list[_Value] = field(default_factory=list)
    key: list[str] = field(default_factory=list)
    key_line: int = 0
    header: int = 0  # number of opening brackets
    in_value: bool = False
    here: Place = ()

    def places(self, text: str) -> list[tuple[Place, int]]:
        """Return the position and line number of each entry, in document order."""
        found: list[tuple[Place, int]] = []
        line = 1
        for token in TOKEN.finditer(text):
            kind, token_text = token.lastgroup or "", token[0]
            if kind == "comment":
                continue
            if self.in_value:
                if place := self._value(kind, token_text):
                    found.append((place, line))
            elif place := self._key(kind, token_text, line):
                found.append((place, self.key_line))
            line += token_text.count("\n")
        return found

    def _key(self, kind: str, text: str, line: int) -> Place:
        """Process one token of a key, and return the key's position once the key is complete."""
        if kind == "word":
            self.key_line = line
            self.key.append(_unquoted(text))
        elif text == "[":
            self.header += 1
        elif text == "]":
            self.header -= 1
            if self.key:
                return self._open_table(is_item=self.header == 1)
        elif text == "=":
            base = self.opened[-1].place if self.opened else self.table
            self.here = (*base, *self._taken())
            self.in_value = True
            return self.here
        elif text == "}":
            self._close()
        return ()

    def _value(self, kind: str, text: str) -> Place:
        """Process one token of a value; return the position if the token begins a list item."""
        begins = kind in ("word", "long") or text in ("[", "{")
        place: Place = ()
        if begins and self.opened and self.opened[-1].item is not None:
            self.here = place = (*self.opened[-1].place, self.opened[-1].item)
        if text == "[":
            self.opened.append(_Value(self.here, 0))
        elif text == "{":
            self.opened.append(_Value(self.here))
            self.in_value = False
        elif text in ("]", "}"):
            self._close()
        elif text == ",":
            self._next()
        elif text == "\n" and not self.opened:
            self.in_value = False
        return place

    def _next(self) -> None:
        """Move to the next list item, or to the next key of an inline table, after a comma."""
        top = self.opened[-1]
        if top.item is None:
            self.in_value = False
        else:
            top.item += 1

    def _close(self) -> None:
        self.opened.pop()
        self.in_value = True

    def _taken(self) -> list[str]:
        """Return the parts of the current dotted key, and prepare for the next key."""
        words, self.key = self.key, []
        return words

    def _open_table(self, *, is_item: bool) -> Place:
        """Process a table header, and return the position of its table in the document."""
        *outer, name = self._taken()
        place: Place = ()
        for word in outer:
            place = (*place, word)
            if place in self.last_item:
                place = (*place, self.last_item[place])
        place = (*place, name)
        if is_item:
            self.last_item[place] = self.last_item.get(place, -1) + 1
            place = (*place, self.last_item[place])
        self.table = place
        return place


def _unquoted(word: str) -> str:
    return next(iter(tomllib.loads(f"{word} = 0"))) if word[0] in "\"'" else word
