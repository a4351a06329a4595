"""Format values, tables and column descriptions for data set files."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping

from slipscale.experiments.dataset.schema import MISSING
from slipscale.experiments.steps.columns import Column
from slipscale.experiments.steps.trial import Value
from slipscale.faults.spreadsheet_cells import harmless_cell

# Times are stored to the microsecond, because the clocks of key events are not more precise.
DIGITS = 6
SECONDS = "s"
# Smaller numbers than this would lose too much with 6 decimals, such as levels in m.
SMALL = 0.01
SIGNIFICANT_DIGITS = 9


def cell(value: Value, units: str = "") -> str:
    r"""Format a value for a table.

    A number has up to 6 decimals. A number below 0.01 has up to 9 significant digits instead, so
    that no number is changed by more than 0.005 %, unless it is a time in s. Text that a
    spreadsheet would evaluate gets an apostrophe.

    >>> cell(None), cell(2.0), cell(12.345678901), cell("a\tb")
    ('n/a', '2', '12.345679', 'a b')
    >>> cell("=1+1"), cell("-3")
    ("'=1+1", '-3')
    >>> cell(5.051750000000001e-07), cell(0.00051234567, "s")
    ('0.000000505175', '0.000512')
    """
    if value is None:
        return MISSING
    if isinstance(value, float):
        digits = DIGITS
        if 0 < abs(value) < SMALL and units != SECONDS:
            digits = SIGNIFICANT_DIGITS - 1 - math.floor(math.log10(abs(value)))
        return f"{round(value, digits):.{digits}f}".rstrip("0").rstrip(".")
    return harmless_cell(" ".join(str(value).split())) or MISSING


def table(header: list[str], rows: list[list[str]]) -> str:
    """Return a TSV table in which cells are quoted if necessary."""
    text = io.StringIO()
    writer = csv.writer(text, delimiter="\t", lineterminator="\n")
    writer.writerows([header, *rows])
    return text.getvalue()


def sidecar(described: Mapping[str, Column]) -> dict[str, dict[str, object]]:
    """Return column descriptions in BIDS format."""
    return {
        name: {"Description": column.description}
        | ({"Units": column.units} if column.units else {})
        | ({"Levels": {cell(k): v for k, v in column.levels.items()}} if column.levels else {})
        for name, column in described.items()
    }
