"""Write tables as CSV; a million rows take no longer to write than to read.

pandas converts every cell to text one by one. In experimental data few values are distinct
(participants, amplitudes, ratings), so each distinct value is converted only once.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from slipscale.analysis.writing.spreadsheet_cells import harmless_cell

if TYPE_CHECKING:
    from pathlib import Path


#: Characters that require quotation marks around a cell.
SPECIAL = re.compile(r'[",\r\n]')


def write_csv(table: pd.DataFrame, path: Path) -> None:
    """Write a table as UTF-8 CSV with LF: a header line, no index, missing cells empty.

    The output equals that of pandas' ``to_csv``, except for texts that a spreadsheet would
    evaluate.
    """
    with path.open("w", encoding="utf-8", newline="") as file:
        rows = zip(*(_words(table[name]) for name in table.columns), strict=True)
        header = ",".join(_cell(name) for name in table.columns)
        file.write("\n".join([header, *map(",".join, rows), ""]))


def _cell(text: str) -> str:
    """Return a text as one cell, safe for spreadsheets and quoted if necessary."""
    cell = harmless_cell(text)
    return '"' + cell.replace('"', '""') + '"' if SPECIAL.search(cell) else cell


def _words(column: pd.Series[Any]) -> list[str]:
    codes, values = pd.factorize(column)
    # A missing cell has code -1, which selects the last word: the empty one.
    told = (_cell(each) if isinstance(each, str) else str(each) for each in values.tolist())
    words = np.array([*told, ""], dtype=object)
    found: list[str] = words[codes].tolist()
    return found
