"""Convert the column options of ``slipscale analyse`` to a table mapping."""

from __future__ import annotations

import re
from argparse import Namespace
from collections.abc import Sequence

from slipscale.analysis.reading.mapping import Columns, TableMapping, parse_mapping
from slipscale.faults import UserError

ANSWERS = ("yes", "no", "missing", "alternatives")
SHAPE = ("participant_from_name", "people_in_columns", "matrix", "quadruple", "triad", "rows_of")
OTHERS = ("in_unit", "levels", "only", "decimal", "sheet", "no_header", *ANSWERS, *SHAPE)
NUMBER_AT_END = re.compile(r"(?:\d+(?:[.,]\d+)?|[.,]\d+)$")
#: Ends of the text before a number that may be part of the number: -20, 1e-3, 1.2.3, 0_5.
UNCLEAR_BEFORE = re.compile(r"(?:[-+−.,]|\d[eE]|\d[_ ])$")
#: Number in which a comma may separate thousands.
THOUSANDS = re.compile(r"[1-9]\d{0,2},\d{3}")


def mapping_from(args: Namespace) -> TableMapping | None:
    """Return the column mapping that the options define, or None if no such option is given.

    Raises
    ------
    UserError
        If the options contradict each other.
    """
    given = [name for name in (*Columns.model_fields, *OTHERS) if _stated(getattr(args, name))]
    if not given:
        if args.map:
            raise UserError(
                "--map: requires options that name the columns, such as --participant and "
                "--stimulus"
            )
        return None
    columns = {name: value for name in Columns.model_fields if (value := getattr(args, name))}
    name, colon, unit = columns.get("stimulus", "").rpartition(":")
    if not colon:
        name, unit = unit, ""
    stimulus = {"unit": unit} | ({"in_unit": args.in_unit} if args.in_unit else {})
    if args.levels or args.people_in_columns:
        # These tables have no stimulus column, so the option gives the name of the stimulus.
        columns.pop("stimulus", None)
        stimulus |= {"name": name} if name else {}
    elif name:
        columns["stimulus"] = name
    only: dict[str, list[str]] = {}
    for column, value in _pairs(args.only or (), "--only"):
        only.setdefault(column, []).append(value)
    cells = {"only": only, "decimal": args.decimal, "sheet": args.sheet}
    table = {"table": {key: value for key, value in cells.items() if value}}
    if any(name not in cells for name in given):
        table |= {
            "columns": columns,
            "stimulus": {key: value for key, value in stimulus.items() if value},
            "shape": _shape(args),
            "answers": {key: value for key in ANSWERS if (value := getattr(args, key)) is not None},
            "levels": _levels(args.levels or ()),
        }
    return parse_mapping(table, "options")


def _stated(value: object) -> bool:
    return value is not None and value is not False


def _shape(args: Namespace) -> dict[str, object]:
    shape: dict[str, object] = {
        name: value for name in SHAPE if _stated(value := getattr(args, name))
    }
    for name in ("quadruple", "triad"):
        if name in shape:
            shape[name] = [part.strip() for part in getattr(args, name).split(",")]
    if args.rows_of:
        ((column, values),) = _pairs([args.rows_of], "--rows-of")
        stimulus, _, answer = values.partition(",")
        shape["rows_of"] = {"column": column, "stimulus": stimulus, "answer": answer}
    return shape | ({"header": False} if args.no_header else {})


def _pairs(given: Sequence[str], option: str) -> list[tuple[str, str]]:
    pairs = [text.rpartition("=") for text in given]
    if wrong := [last for column, sign, last in pairs if not (sign and column)]:
        raise UserError("{option} {name}: expected COLUMN=VALUE", option=option, name=wrong[0])
    return [(column, value) for column, _, value in pairs]


def _levels(given: Sequence[str]) -> dict[str, float]:
    found: dict[str, float] = {}
    for text in given:
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
