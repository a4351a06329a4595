"""Write tables that French versions of Excel can open."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.faults.spreadsheet_cells import harmless_cell

if TYPE_CHECKING:
    import pandas as pd


def write_french(table: pd.DataFrame, path: Path) -> None:
    """Write a table with semicolons, decimal commas and a byte-order mark."""
    with path.open("w", encoding="utf-8-sig", newline="") as file:
        writer = csv.writer(file, delimiter=";")
        writer.writerow([harmless_cell(str(name)) for name in table.columns])
        rows = table.astype(object).where(table.notna(), None)
        writer.writerows([_french(value) for value in row] for row in rows.to_numpy(object))


def _french(value: object) -> str:
    """Format a cell for French Excel.

    >>> _french(0.5), _french(True), _french("-oui"), _french(None)
    ('0,5', 'VRAI', "'-oui", '')
    """
    if value is None:
        return ""
    if isinstance(value, bool):
        return "VRAI" if value else "FAUX"
    if isinstance(value, float):
        return repr(float(value)).removesuffix(".0").replace(".", ",")
    return harmless_cell(str(value))
