"""Generate the study editor's form, with every field of a study file, from the JSON Schema.

Keys, types, units, defaults, choices and descriptions come from the schema, values from the file,
and errors from the parser. The form therefore also covers protocols that a laboratory added.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from slipscale.experiments.lab.console.actions.study_changes import Kind
from slipscale.experiments.study.file import file_names
from slipscale.experiments.study.schema import UNITS, Schema, study_schema
from slipscale.faults.toml_lines import Place
from slipscale.faults.validation import Told
from slipscale.stimuli.level_names import is_level
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

IN_UM = UNITS["_um_pp"]
KINDS: Mapping[str, Kind] = {"boolean": "switch", "integer": "number", "number": "number"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A form element, and its position in the study file.

    Parameters
    ----------
    place : tuple
        Position in the study file: keys, and indices of array items, from 0.
    name : str
        Label of the element: its key without the unit or, in an array, its number (from 1).
    why : str
        The element's description in the schema.
    faults : tuple of str
        Error messages for this element, without errors in nested elements.
    """

    place: Place
    name: str
    why: str = ""
    faults: tuple[str, ...] = ()

    @property
    def path(self) -> str:
        """The position as JSON, for use in the page's script."""
        return json.dumps(self.place)

    @property
    def anchor(self) -> str:
        """The id of the HTML element, derived from the position."""
        return "field-" + "-".join(re.sub(r"\W+", "_", str(part)) for part in self.place)


@dataclass(frozen=True, slots=True, kw_only=True)
class Field(Part):
    """A form field: its input type, displayed value and allowed values."""

    kind: Kind
    value: str
    default: str = ""
    unit: str = ""
    choices: tuple[str, ...] = ()
    needed: bool = False

    @property
    def shown(self) -> bool:
        """Whether the field is displayed first, because it is set, required or invalid."""
        return bool(self.value or self.needed or self.faults)


@dataclass(frozen=True, slots=True, kw_only=True)
class Table(Part):
    """A table of the study file, with its fields, nested tables and lists of tables.

    Parameters
    ----------
    absent : tuple of Part
        Nested tables that the file does not contain and that can be added.
    entries : bool
        Whether the keys are defined by the study file instead of the schema, as for the options of
        a question.
    """

    fields: tuple[Field, ...] = ()
    tables: tuple[Table, ...] = ()
    lists: tuple[Cards, ...] = ()
    absent: tuple[Part, ...] = ()
    entries: bool = False
    content: Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Cards(Part):
    """A list of tables, such as tasks. ``offered`` lists the items that can be added."""

    items: tuple[Table, ...]
    offered: tuple[str, ...] = ()


@cache
def _schema() -> Schema:
    return study_schema()


class StudyForm:
    """The form for editing a study file.

    Parameters
    ----------
    content : dict
        Content of the file, which may be invalid.
    faults : sequence of Told
        The errors in the file.
    """

    def __init__(self, content: dict[str, Any], faults: Sequence[Told]) -> None:
        self._names = file_names(content)
        self._faults = faults
        self._shown: set[str] = set()
        self.root = self._table((), _schema(), content)
        #: Errors at positions of the file for which the form has no field.
        self.elsewhere = tuple(each.whole for each in faults if each.whole not in self._shown)

    def _faults_at(self, place: Place, *, items: bool = False) -> tuple[str, ...]:
        """Return the errors at a position and, if ``items`` is True, in the list's elements."""
        found = [
            each
            for each in self._faults
            if place
            and (
                each.place == place
                or (items and each.place[:-1] == place and isinstance(each.place[-1], int))
            )
        ]
        self._shown |= {each.whole for each in found}
        return tuple(each.message for each in found)

    def _part(self, place: Place, schema: Schema) -> dict[str, Any]:
        return {
            "place": place,
            "name": self._name(place) if place else "",
            "why": schema.get("description", ""),
            "faults": self._faults_at(place),
        }

    def _quantity(self, place: Place) -> Quantity:
        """Return the quantity of the levels at a position (possibly a varied parameter)."""
        return self._names.quantity_in(place[0])

    def _name(self, place: Place) -> str:
        """Return the label of an element: its key without the unit or, in an array, its number."""
        key = place[-1]
        if isinstance(key, int):
            return str(key + 1)
        ends = (f"_{self._quantity(place).suffix}", *UNITS)
        end = next((each for each in ends if key.endswith(each)), "")
        return key.removesuffix(end)

    def _table(self, place: Place, schema: Schema, content: Mapping[str, Any]) -> Table:
        fields: list[Field] = []
        tables: list[Table] = []
        lists: list[Cards] = []
        absent: list[Part] = []
        needed = schema.get("required", ())
        for declared, inner in schema.get("properties", {}).items():
            key = declared
            if is_level(name := PLATE_AMPLITUDE.in_code[declared]):
                key = self._quantity((*place, declared)).named(name)
            here, value = (*place, key), content.get(key)
            found = _definition(inner)
            if "const" in found:
                continue  # the protocol, which is the title of the card
            if _is_table(found) or isinstance(value, dict):
                if value is None:
                    absent.append(Part(**self._part(here, inner)))
                elif isinstance(value, dict):
                    tables.append(self._inner(here, found, inner, value))
            elif _holds_tables(found):
                lists.append(self._cards(here, found, value))
            else:
                fields.append(self._field(here, found, value, needed=declared in needed))
        unknown = self._unknown(place, schema, content)
        fields += [
            Field(**self._part((*place, key), {}), kind="text", value=_words(value), needed=True)
            for key, value in content.items()
            if key in unknown and not isinstance(value, dict | list)
        ]
        return Table(
            **self._part(place, schema),
            fields=tuple(fields),
            tables=tuple(tables),
            lists=tuple(lists),
            absent=tuple(absent),
            content=content,
        )

    def _unknown(self, place: Place, schema: Schema, content: Mapping[str, Any]) -> set[str]:
        """Return misspelt keys, which are shown with their errors and can be cleared."""
        declared = set(schema.get("properties", {}))
        return {key for key in content if key not in declared and self._faults_at((*place, key))}

    def _inner(
        self, place: Place, found: Schema, described: Schema, value: Mapping[str, Any]
    ) -> Table:
        """Return the form of a nested table, whose keys the schema or the study file defines."""
        if "properties" in found:
            return self._table(place, {**found, "description": described.get("description")}, value)
        return Table(
            **self._part(place, described),
            fields=tuple(
                Field(**self._part((*place, key), {}), kind="text", value=_words(inner))
                for key, inner in value.items()
                if not isinstance(inner, dict)
            ),
            tables=tuple(
                self._inner((*place, key), {}, {}, inner)
                for key, inner in value.items()
                if isinstance(inner, dict)
            ),
            entries=True,
            content=value,
        )

    def _cards(self, place: Place, schema: Schema, value: Any) -> Cards:
        items = schema["items"]
        kinds = {each["properties"]["protocol"]["const"]: each for each in _choices(items)}
        return Cards(
            **self._part(place, schema),
            items=tuple(
                self._table(
                    (*place, number),
                    kinds.get(table.get("protocol"), {}) if kinds else _definition(items),
                    table,
                )
                for number, table in enumerate(value if isinstance(value, list) else ())
                if isinstance(table, dict)
            ),
            offered=tuple(kinds),
        )

    def _field(self, place: Place, schema: Schema, value: Any, *, needed: bool) -> Field:
        if "anyOf" in schema:
            # The value determines the type; without a value, the first alternative is used.
            several = schema["anyOf"]
            is_list = isinstance(value, list) or (value is None and several[0]["type"] == "array")
            schema = {**schema, "type": "array" if is_list else "string", "items": {}}
        kind, choices = _kind(schema)
        unit = schema.get("unit", "")
        quantity = self._quantity(place)
        in_um = unit == IN_UM and not quantity.of_plate
        part = self._part(place, schema) | {"faults": self._faults_at(place, items=True)}
        return Field(
            **part,
            kind=kind,
            value="" if value is None else _words(value, "\n" if kind == "lines" else ", "),
            default="" if in_um else _words(schema.get("default", "")),
            unit=quantity.unit_in_full if in_um else unit.removeprefix("none"),
            choices=choices,
            needed=needed,
        )


def _kind(schema: Schema) -> tuple[Kind, tuple[str, ...]]:
    """Return the input type for a value, and its choices, if any."""
    if schema.get("type") == "array":
        items = schema.get("items", {})
        if "enum" in items:
            return "several", tuple(map(str, items["enum"]))
        return ("numbers" if items.get("type") in KINDS else "lines"), ()
    if "enum" in schema:
        return "choice", tuple(map(str, schema["enum"]))
    return KINDS.get(schema.get("type", ""), "text"), ()


def _definition(schema: Schema) -> Schema:
    """Resolve a schema that refers to a definition; return other schemas unchanged."""
    if "$ref" not in schema:
        return schema
    found: Schema = _schema()["$defs"][schema["$ref"].rpartition("/")[2]]
    return found


def _choices(schema: Schema) -> list[Schema]:
    return [_definition(each) for each in schema.get("oneOf", ())]


def _is_table(schema: Schema) -> bool:
    return schema.get("type") == "object"


def _holds_tables(schema: Schema) -> bool:
    items = schema.get("items", {})
    return schema.get("type") == "array" and ("$ref" in items or "oneOf" in items)


def _words(value: Any, between: str = ", ") -> str:
    """Format a value as the text of a form input."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return between.join(map(_words, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
