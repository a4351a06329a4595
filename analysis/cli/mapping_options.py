"""Convert the column options of ``slipscale analyse`` to a table mapping."""

from __future__ import annotations

import re
from argparse import Namespace
from collections.abc import Sequence

from slipscale.analysis.reading.mapping import TableMapping, parse_mapping
from slipscale.faults import UserError

COLUMNS = (
    *("participant", "stimulus", "response", "answer", "yes_count", "n", "reference"),
    *("first", "second", "dissimilarity"),
    *("group", "factor", "session", "run", "block", "trial"),
)
ANSWERS = ("yes", "no", "missing", "alternatives")
OTHERS = ("in_unit", "levels", "only", "decimal", "sheet", *ANSWERS)
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
    if not any(getattr(args, name) for name in (*COLUMNS, *OTHERS)):
        if args.map:
            raise UserError(
                "--map: requires options that name the columns, such as --participant and "
                "--stimulus"
            )
        return None
    columns = {name: value for name in COLUMNS if (value := getattr(args, name))}
    name, colon, unit = columns.get("stimulus", "").rpartition(":")
    if not colon:
        name, unit = unit, ""
    stimulus = {"unit": unit} | ({"in_unit": args.in_unit} if args.in_unit else {})
    if args.levels:
        # A wide table has no stimulus column, so the option gives the name of the stimulus.
        columns.pop("stimulus", None)
        stimulus |= {"name": name} if name else {}
    elif name:
        columns["stimulus"] = name
    only: dict[str, list[str]] = {}
    for column, value in _pairs(args.only or (), "--only"):
        only.setdefault(column, []).append(value)
    cells = {"only": only, "decimal": args.decimal, "sheet": args.sheet}
    table = {"table": {key: value for key, value in cells.items() if value}}
    if any(getattr(args, name) for name in OTHERS if name not in cells) or columns:
        table |= {
            "columns": columns,
            "stimulus": stimulus,
            "answers": {key: value for key in ANSWERS if (value := getattr(args, key)) is not None},
            "levels": _levels(args.levels or ()),
        }
    return parse_mapping(table, "options for columns")


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
