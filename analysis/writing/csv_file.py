"""Write tables as CSV files, including tables with millions of rows.

pandas converts every cell to text. Because columns of experimental data contain few distinct values
(participants, amplitudes, ratings), this module converts each distinct value only once.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from slipscale.faults.spreadsheet_cells import harmless_cell

#: Cells with these characters are written in quotation marks.
SPECIAL = re.compile(r'[",\r\n]')


def write_csv(table: pd.DataFrame, path: Path) -> None:
    """Write a table as UTF-8 CSV with LF line ends, without its index.

    Missing cells are empty. The file is the same as that of pandas' ``to_csv``, except for cells
    that a spreadsheet would evaluate as formulas.
    """
    with path.open("w", encoding="utf-8", newline="") as file:
        rows = zip(*(_words(table[name]) for name in table.columns), strict=True)
        header = ",".join(_cell(name) for name in table.columns)
        file.write("\n".join([header, *map(",".join, rows), ""]))


def _cell(text: str) -> str:
    """Return text as a CSV cell, quoted if necessary and safe for spreadsheets."""
    cell = harmless_cell(text)
    return '"' + cell.replace('"', '""') + '"' if SPECIAL.search(cell) else cell


def _words(column: pd.Series[Any]) -> list[str]:
    codes, values = pd.factorize(column)
    # A missing cell has code -1, which selects the last word, an empty string.
    texts = (_cell(each) if isinstance(each, str) else str(each) for each in values.tolist())
    words = np.array([*texts, ""], dtype=object)
    found: list[str] = words[codes].tolist()
    return found
