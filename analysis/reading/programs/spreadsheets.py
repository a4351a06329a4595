"""Read Excel workbooks and SPSS files."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import ParseError

import numpy as np
import pandas as pd

from slipscale.analysis.reading.programs.records import as_cell
from slipscale.faults import UserError
from slipscale.faults.message import Message

#: Maximum unpacked size of a workbook.
LARGEST_WORKBOOK_MB = 300
#: Maximum number of cells of a sheet, with blank rows counted as one cell.
MOST_CELLS = 20_000_000
#: A range of merged cells in the XML of a sheet.
MERGED = re.compile(rb'<mergeCell [^>]*ref="([^"]+)"')


def read_excel(content: bytes, path: Path, sheet: str | None) -> pd.DataFrame:
    """Read a sheet with cells as text or numbers; ``line`` is the row number in Excel.

    Parameters
    ----------
    sheet : str or None
        Name of the sheet; None selects the only non-empty sheet.

    Raises
    ------
    UserError
        If the file is not a workbook or has macros or merged cells, or if a sheet must be selected.
    """
    import openpyxl
    from openpyxl.utils.exceptions import InvalidFileException

    if path.suffix.lower() != ".xlsx":
        raise UserError(
            "{path}: Excel files in the format {format} (with macros, or older than 2007) are "
            "not supported; save the file as .xlsx or as CSV UTF-8",
            path=path,
            format=path.suffix,
        )
    try:
        archive = zipfile.ZipFile(io.BytesIO(content))
        parts = archive.infolist()
        if sum(part.file_size for part in parts) > LARGEST_WORKBOOK_MB * 2**20:
            raise UserError(
                "{path}: more than {largest_mb} MB when unpacked; expected a CSV file",
                path=path,
                largest_mb=LARGEST_WORKBOOK_MB,
            )
        if any(part.filename.endswith("vbaProject.bin") for part in parts):
            raise UserError(
                "{path}: workbooks with macros are not supported; save the file as .xlsx or CSV",
                path=path,
            )
        book = openpyxl.load_workbook(io.BytesIO(content), read_only=True, data_only=True)
    except (
        *(zipfile.BadZipFile, InvalidFileException, ParseError, KeyError, ValueError, TypeError),
        *(AttributeError, IndexError, OSError, NotImplementedError, EOFError),
    ) as error:
        raise UserError(
            "{path}: not a readable Excel workbook ({error}); save it as .xlsx or CSV UTF-8",
            path=path,
            error=error,
        ) from None
    filled = [found for found in book.worksheets if len([*islice(_rows(found, path), 2)]) > 1]
    chosen = [found for found in filled if sheet is None or found.title == sheet]
    if len(chosen) != 1:
        sheets = ", ".join(f"'{found.title}'" for found in filled) or "none with rows"
        expected = (
            "the name of one sheet (--sheet)"
            if sheet is None
            else Message("a sheet '{sheet}'", sheet=sheet)
        )
        raise UserError(
            "{path}: the sheets are {sheets}; expected {expected}",
            path=path,
            sheets=sheets,
            expected=expected,
        )
    (table,) = chosen
    if merged := MERGED.search(archive.read(table._worksheet_path)):  # noqa: SLF001 - as openpyxl reads it
        raise UserError(
            "{path}: cells {where} are merged; expected a header line and one row per trial, "
            "with one value per cell",
            path=path,
            where=merged[1].decode(),
        )
    rows = list(_rows(table, path))
    if not rows:
        raise UserError("{path}: the file is empty; expected a header line and rows", path=path)
    width = max(len(row) for _, row in rows)
    names = ["" if name is None else str(name).strip() for name in _padded(rows[0][1], width)]
    cells = [[as_cell(value) for value in _padded(row, width)] for _, row in rows[1:]]
    frame = pd.DataFrame(cells, columns=pd.Index(names), dtype=object)
    return _with_lines(frame, [number for number, _ in rows[1:]])


def _rows(sheet: Any, path: Path) -> Iterator[tuple[int, tuple[object, ...]]]:
    """Yield the number and the cells of each row with a value, up to the last cell with one.

    The size that a workbook states is not believed: one blank cell in the last row of a sheet makes
    it a million rows.
    """
    sheet.reset_dimensions()
    seen = 0
    for number, row in enumerate(sheet.iter_rows(values_only=True), start=1):
        seen += 1 + len(row)
        if seen > MOST_CELLS:
            raise UserError(
                "{path}, sheet '{sheet}': more than {most_cells:,} cells; expected a CSV file",
                path=path,
                sheet=sheet.title,
                most_cells=MOST_CELLS,
            )
        filled = [at for at, value in enumerate(row) if value is not None and str(value).strip()]
        if filled:
            yield number, row[: filled[-1] + 1]


def _padded(row: tuple[object, ...], width: int) -> tuple[object, ...]:
    return row + (None,) * (width - len(row))


def read_spss(content: bytes, path: Path, labelled: Sequence[str]) -> pd.DataFrame:
    """Read the cases in an SPSS file, as text or numbers; ``line`` is the row number.

    Parameters
    ----------
    labelled : sequence of str
        Columns whose values are replaced by their labels ("female" instead of 2).

    Raises
    ------
    UserError
        If the file cannot be read as an SPSS file.
    """
    import pyreadstat

    try:
        found, meta = pyreadstat.read_sav(str(path))
    except (pyreadstat.ReadstatError, pyreadstat.PyreadstatError, OSError, ValueError) as error:
        raise UserError(
            "{path}: not a readable SPSS file ({error}); save it in SPSS as .sav or CSV",
            path=path,
            error=error,
        ) from None
    del content  # The library opens the file itself.
    frame = pd.DataFrame(index=found.index)
    for name in found.columns:
        labels = meta.variable_value_labels.get(name, {}) if name in labelled else {}
        cells = [as_cell(labels.get(value, value)) for value in found[name].tolist()]
        frame[name] = pd.Series(cells, dtype=object)
    return _with_lines(frame, list(range(1, len(frame) + 1)))


def _with_lines(frame: pd.DataFrame, lines: Sequence[int]) -> pd.DataFrame:
    return frame.assign(line=np.array(lines, np.int64))
