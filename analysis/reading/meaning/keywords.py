"""Convert what options or keywords state about a table to its mapping."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from slipscale.analysis.reading.meaning.mapping import Columns, TableMapping, parse_mapping
from slipscale.faults import UserError

ANSWERS = ("yes", "no", "missing", "alternatives")
SHAPE = ("participant_from_name", "people_in_columns", "matrix", "quadruple", "triad", "rows_of")
CELLS = ("only", "decimal", "sheet")
#: Everything that can be stated about a table, with the names of the options.
MEANINGS = (*Columns.model_fields, "in_unit", "levels", *CELLS, "no_header", *ANSWERS, *SHAPE)
NUMBER_AT_END = re.compile(r"(?:\d+(?:[.,]\d+)?|[.,]\d+)$")
#: Ends of the text before a number that may be part of the number: -20, 1e-3, 1.2.3, 0_5.
UNCLEAR_BEFORE = re.compile(r"(?:[-+−.,]|\d[eE]|\d[_ ])$")
#: Number in which a comma may separate thousands.
THOUSANDS = re.compile(r"[1-9]\d{0,2},\d{3}")


def mapping_of(given: Mapping[str, object]) -> TableMapping:
    """Return the mapping for values of `MEANINGS`, as written in options or in Python.

    A stimulus may contain its unit (``"pressure:Pa"``). Levels are a mapping (column -> level) or
    names with levels (``["p20=20", "p0,5"]``). Rows are selected by a mapping (column -> values) or
    by ``["column=value"]``.

    Raises
    ------
    UserError
        If a name is unknown, or values contradict each other.
    """
    if unknown := [name for name in given if name not in MEANINGS]:
        raise UserError(
            "{name}: unknown; expected one of {known}",
            name=unknown[0],
            known=", ".join(MEANINGS),
        )
    stated = {name: value for name, value in given.items() if value is not None}
    columns = {name: value for name in Columns.model_fields if (value := stated.get(name))}
    name, unit = name_and_unit(str(columns.get("stimulus", "")))
    stimulus = {"unit": unit, "in_unit": stated.get("in_unit")}
    if stated.get("levels") or stated.get("people_in_columns"):
        # These tables have no stimulus column, so the option gives the name of the stimulus.
        columns.pop("stimulus", None)
        stimulus |= {"name": name}
    elif name:
        columns["stimulus"] = name
    cells = {name: stated[name] for name in CELLS if name in stated}
    if "only" in cells:
        cells["only"] = _selected(cells["only"])
    table: dict[str, object] = {"table": cells}
    if set(stated) - set(CELLS):
        table |= {
            "columns": columns,
            "stimulus": {key: value for key, value in stimulus.items() if value},
            "answers": {key: stated[key] for key in ANSWERS if key in stated},
            "levels": _levels(stated.get("levels", ())),
            "shape": _shape(stated),
        }
    return parse_mapping(table, "options")


def name_and_unit(stimulus: str) -> tuple[str, str]:
    """Return the name and the unit of a stimulus; the unit may be empty.

    >>> name_and_unit("pressure:Pa"), name_and_unit("pressure")
    (('pressure', 'Pa'), ('pressure', ''))
    """
    name, colon, unit = stimulus.rpartition(":")
    return (name, unit) if colon else (unit, "")


def _shape(stated: Mapping[str, object]) -> dict[str, object]:
    shape = {name: stated[name] for name in SHAPE if name in stated}
    for name in ("quadruple", "triad"):
        if isinstance(text := shape.get(name), str):
            shape[name] = [part.strip() for part in text.split(",")]
    if isinstance(text := shape.get("rows_of"), str):
        ((column, values),) = _pairs([text], "--rows-of")
        stimulus, _, answer = values.partition(",")
        shape["rows_of"] = {"column": column, "stimulus": stimulus, "answer": answer}
    return shape | ({"header": False} if stated.get("no_header") else {})


def _selected(given: object) -> object:
    if isinstance(given, Mapping):
        return given
    only: dict[str, list[str]] = {}
    for column, value in _pairs(_texts(given), "--only"):
        only.setdefault(column, []).append(value)
    return only


def _texts(given: object) -> list[str]:
    return (
        [given]
        if isinstance(given, str)
        else list(map(str, given))
        if isinstance(given, Iterable)
        else [str(given)]
    )


def _pairs(given: Sequence[str], option: str) -> list[tuple[str, str]]:
    pairs = [text.rpartition("=") for text in given]
    if wrong := [last for column, sign, last in pairs if not (sign and column)]:
        raise UserError("{option} {name}: expected COLUMN=VALUE", option=option, name=wrong[0])
    return [(column, value) for column, _, value in pairs]


def _levels(given: object) -> object:
    if isinstance(given, Mapping):
        return given
    found: dict[str, float] = {}
    for text in _texts(given):
        column, sign, value = text.rpartition("=")
        if not sign:
            column, value = text, _number_at_end(text)
        if column in found:
            raise UserError(
                "--levels {text}: column {column} is given twice; expected only once",
                text=text,
                column=column,
            )
        try:
            found[column] = float(value)
        except ValueError:
            raise UserError(
                "--levels {text}: expected COLUMN=LEVEL with a number, or a column name that "
                "ends with a number",
                text=text,
            ) from None
    return found


def _number_at_end(column: str) -> str:
    """Return the number at the end of a column name with a decimal point, or "" if there is none.

    Raises
    ------
    UserError
        If the number could begin earlier, have a sign, or contain a separator.
    """
    found = NUMBER_AT_END.search(column)
    if found is None:
        return ""
    number, before = found[0], column[: found.start()]
    separated = number[0] in ".," and before[-1:].isalnum()
    if separated or UNCLEAR_BEFORE.search(before) or THOUSANDS.fullmatch(number):
        raise UserError(
            "--levels {column}: the number at the end could be read in several ways; expected "
            "{column}=LEVEL, with the level as a number",
            column=column,
        )
    return number.replace(",", ".")
