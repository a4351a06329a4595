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
OTHERS = ("in_unit", "levels", "only", "decimal", "sheet", "yes", "alternatives")
NUMBER_AT_END = re.compile(r"\d+(?:\.\d+)?$")


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
    table = {
        "only": only,
        "decimal": args.decimal,
        "sheet": args.sheet,
    }
    return parse_mapping(
        {
            "columns": columns,
            "stimulus": stimulus,
            "answers": {
                key: value
                for key in ("yes", "alternatives")
                if (value := getattr(args, key)) is not None
            },
            "levels": _levels(args.levels or ()),
            "table": {key: value for key, value in table.items() if value},
        },
        "options for columns",
    )


def _pairs(given: Sequence[str], option: str) -> list[tuple[str, str]]:
    pairs = [text.rpartition("=") for text in given]
    if wrong := [last for column, sign, last in pairs if not (sign and column)]:
        raise UserError(f"{option} {wrong[0]}: expected COLUMN=VALUE")
    return [(column, value) for column, _, value in pairs]


def _levels(given: Sequence[str]) -> dict[str, float]:
    found: dict[str, float] = {}
    for text in given:
        column, sign, value = text.rpartition("=")
        if not sign:
            column = text
            ends = NUMBER_AT_END.search(text)
            value = ends[0] if ends else ""
        try:
            found[column] = float(value)
        except ValueError:
            raise UserError(
                f"--levels {text}: expected COLUMN=LEVEL with a number, or a column name that "
                "ends with a number"
            ) from None
    return found
