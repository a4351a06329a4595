"""Read text tables with line numbers, including cells that contain line breaks."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from slipscale.analysis.reading.dialect import decoded, separator_of
from slipscale.faults import UserError

#: Number of bytes read at the beginning of a text file to recognise its format.
HEAD = 65_536


def head_of(content: bytes, path: Path) -> str:
    """Return the beginning of a text file, or "" if the file is not text."""
    try:
        return decoded(content[:HEAD], path)[0].decode("utf-8").lstrip("\r\n")
    except (UserError, UnicodeDecodeError):
        return ""


def records(text: str, path: Path) -> list[tuple[int, list[str]]]:
    """Parse a text table; return each non-empty record with the number of its last line.

    Raises
    ------
    UserError
        If a quoted cell is not closed, or a cell is too long.
    """
    separator = separator_of(text.encode())
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    try:
        return [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except csv.Error as error:
        raise UserError(
            "{path}: line {line} cannot be read ({error}); expected quotation marks in pairs",
            path=path,
            line=reader.line_num,
            error=error,
        ) from None


def framed(rows: Sequence[Mapping[str, object]], lines: Sequence[int]) -> pd.DataFrame:
    """Convert rows to a table of cells (see `as_cell`) with the column ``line``."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    frame = pd.DataFrame(
        {name: pd.Series([as_cell(row.get(name)) for row in rows], dtype=object) for name in names}
    )
    return frame.assign(line=np.array(lines, np.int64))


def table_of(names: Sequence[str], rows: Sequence[tuple[int, list[str]]]) -> pd.DataFrame:
    """Convert records to a table; omit cells without a column name."""
    cells = [dict(zip(names, row, strict=False)) for _, row in rows]
    return framed(cells, [line for line, _ in rows])


def as_cell(value: object) -> object:
    """Return a number as it is, None for a missing value, and any other value as text.

    Only text is parsed as numbers later, because a number has no decimal mark to detect.
    """
    plain = value.item() if isinstance(value, np.generic) else value
    text = as_text(plain)
    stored = isinstance(plain, int | float) and not isinstance(plain, bool)
    return plain if stored and text is not None else text


def as_text(cell: object) -> str | None:
    """Format a value as it would appear in a text table; return None for a missing value."""
    if cell is None or (isinstance(cell, float) and np.isnan(cell)):
        return None
    if isinstance(cell, bool | np.bool_):
        return str(bool(cell)).upper()
    if isinstance(cell, float):
        return str(int(cell)) if cell.is_integer() and abs(cell) < 1e15 else repr(float(cell))  # noqa: PLR2004 - whole numbers up to here are exact
    return str(cell)
