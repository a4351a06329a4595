"""Format values, tables and column descriptions for data set files."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping

from slipscale.experiments.dataset.schema import MISSING
from slipscale.experiments.protocol_parts.base import Column
from slipscale.experiments.steps.trial import Value

# Times are stored to the microsecond, because the clocks of key events are not more precise.
DIGITS = 6


def cell(value: Value) -> str:
    r"""Format a value for a table.

    >>> cell(None), cell(2.0), cell(12.345678901), cell("a\tb")
    ('n/a', '2', '12.345679', 'a b')
    """
    if value is None:
        return MISSING
    if isinstance(value, float):
        return f"{round(value, DIGITS):.{DIGITS}f}".rstrip("0").rstrip(".")
    return " ".join(str(value).split()) or MISSING


def table(header: list[str], rows: list[list[str]]) -> str:
    """Return a TSV table in which cells are quoted if necessary."""
    text = io.StringIO()
    writer = csv.writer(text, delimiter="\t", lineterminator="\n")
    writer.writerows([header, *rows])
    return text.getvalue()


def sidecar(described: Mapping[str, Column]) -> dict[str, object]:
    """Return column descriptions in BIDS format."""
    return {
        name: {"Description": column.description}
        | ({"Units": column.units} if column.units else {})
        | ({"Levels": dict(column.levels)} if column.levels else {})
        for name, column in described.items()
    }
