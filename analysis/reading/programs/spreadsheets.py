"""Read Excel workbooks, and files of SPSS and Stata."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import islice, pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from xml.etree.ElementTree import ParseError

import numpy as np
import pandas as pd

from slipscale.analysis.reading.delimited import filled
from slipscale.analysis.reading.programs.records import as_cell
from slipscale.analysis.reading.programs.wanted import SeveralTables, Wanted
from slipscale.faults import UserError
from slipscale.faults.message import Message

#: Maximum unpacked size of a workbook.
LARGEST_WORKBOOK_MB = 300
#: Maximum number of stored cells of a sheet, and Excel's maximum numbers of rows and columns.
MOST_CELLS, MOST_ROWS, MOST_COLUMNS = 20_000_000, 1_048_576, 16_384
#: The start of a row in the XML of a sheet.
ROW = re.compile(rb"<row\b")
#: A range of merged cells in the XML of a sheet.
MERGED = re.compile(rb'<mergeCell [^>]*ref="([A-Z]{1,3}\d{1,7}(?::[A-Z]{1,3}\d{1,7})?)"')
#: A cell with a formula and no value.
FORMULA = re.compile(
    rb'<c r="([A-Z]{1,3}\d{1,7})"[^>]*><f[^>]*(?:/>|>[^<]*</f>)(?:<v ?/>|<v></v>)?</c>'
)


def read_excel(content: bytes, path: Path, wanted: Wanted) -> pd.DataFrame:
    """Read a sheet with cells as text or numbers; ``line`` is the row number in Excel.

    Without a name of a sheet in ``wanted``, the only non-empty sheet is read.

    Raises
    ------
    UserError
        If the file is not a workbook or has macros, cells merged across columns or formulas
        without values, or if a sheet must be selected.
    """
    import openpyxl

    if path.suffix.lower() != ".xlsx":
        raise UserError(
            "{path}: Excel files in the format {format} (with macros, or older than 2007) are "
            "not supported; save the file as .xlsx or as CSV UTF-8",
            path=path,
            format=path.suffix,
        )
    with _as_faults(path):
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
        texts = {each: archive.read(each._worksheet_path) for each in book.worksheets}  # noqa: SLF001
    some = [each for each, text in texts.items() if len([*islice(_rows(each, text, path), 2)]) > 1]
    sheet = wanted.sheet
    chosen = [found for found in some if sheet is None or found.title == sheet]
    if len(chosen) != 1:
        sheets = ", ".join(f"'{found.title}'" for found in some) or "none with rows"
        expected = (
            "the name of one sheet (--sheet)"
            if sheet is None
            else Message("a sheet '{sheet}'", sheet=sheet)
        )
        titles = [found.title for found in chosen]
        raise (partial(SeveralTables, names=titles) if titles else UserError)(
            "{path}: the sheets are {sheets}; expected {expected}",
            path=path,
            sheets=sheets,
            expected=expected,
        )
    (table,) = chosen
    sheet_text = texts[table]
    rows = _below_titles(list(_rows(table, sheet_text, path)))
    if not rows:
        raise UserError("{path}: the file is empty; expected a header line and rows", path=path)
    width = max(len(row) for _, row in rows)
    names = filled(["" if n is None else str(n).strip() for n in _padded(rows[0][1], width)])
    cells = {number: list(_padded(row, width)) for number, row in rows[1:]}
    _fill_merged(cells, sheet_text, path, header=rows[0][0])
    _refuse_formulas(cells, sheet_text, path, names, wanted)
    frame = pd.DataFrame(
        [[as_cell(value) for value in row] for row in cells.values()],
        columns=pd.Index(names),
        dtype=object,
    )
    return _with_lines(frame.loc[:, _named(frame, rows[0][1])], list(cells))


def _named(frame: pd.DataFrame, header: tuple[object, ...]) -> list[bool]:
    """Return whether each column has a name or a value."""
    named = [name is not None for name in _padded(header, frame.shape[1])]
    return [name or bool(some) for name, some in zip(named, frame.notna().any(), strict=True)]


def _below_titles(
    rows: list[tuple[int, tuple[object, ...]]],
) -> list[tuple[int, tuple[object, ...]]]:
    """Return the rows from the header: above it are rows with a single cell, such as a title."""
    widths = [sum(value is not None for value in row) for _, row in rows]
    first = next((place for place, width in enumerate(widths) if width > 1), 0)
    return rows[first:]


def _fill_merged(cells: dict[int, list[object]], sheet: bytes, path: Path, *, header: int) -> None:
    """Repeat the value of merged cells within a column in each of their rows.

    Raises
    ------
    UserError
        If cells of several columns are merged, or cells of the header.
    """
    for merged in MERGED.finditer(sheet):
        left, top, right, bottom = merged_range(merged[1].decode())
        if bottom < header:
            continue
        if left != right or top <= header:
            raise UserError(
                "{path}: cells {where} are merged; expected a header line and one row per trial, "
                "with one value per cell",
                path=path,
                where=merged[1].decode(),
            )
        value = cells[top][left] if top in cells and left < len(cells[top]) else None
        for number in range(top + 1, min(bottom, max(cells, default=0)) + 1):
            if number in cells and left < len(cells[number]):
                if cells[number][left] not in (None, value):
                    raise UserError(
                        "{path}: the merged cells {where} hide other values, first in row "
                        "{number}; split the cells, and state one value per row",
                        path=path,
                        where=merged[1].decode(),
                        number=number,
                    )
                cells[number][left] = value


def merged_range(where: str) -> tuple[int, int, int, int]:
    """Return the first column (from 0) and row (from 1) of a range of cells, and the last ones."""
    from openpyxl.utils.cell import range_boundaries

    left, top, right, bottom = range_boundaries(where)
    return left - 1, top, right - 1, bottom


def _refuse_formulas(
    cells: dict[int, list[object]], sheet: bytes, path: Path, names: Sequence[str], wanted: Wanted
) -> None:
    """Raise `UserError` if a column to read contains formulas without stored values.

    Programs other than spreadsheets write formulas without their values.
    """
    for cell in FORMULA.finditer(sheet):
        left, row, _, _ = merged_range(cell[1].decode())
        if row not in cells or left >= len(names) or cells[row][left] is not None:
            continue
        if wanted.columns is None or names[left] in wanted.columns:
            raise UserError(
                "{path}: cell {where} in column {column} contains a formula without a stored "
                "value; open the file in Excel or LibreOffice and save it",
                path=path,
                where=cell[1].decode(),
                column=names[left],
            )


def _rows(sheet: Any, text: bytes, path: Path) -> Iterator[tuple[int, tuple[object, ...]]]:
    """Yield the number and the cells of each row with a value, up to the last cell with one.

    ``text`` is the XML of the sheet. Only stored cells are visited: a blank cell in the last row of
    a sheet makes it a million rows.
    """
    from openpyxl.worksheet._reader import WorkSheetParser

    seen, book = 0, sheet.parent
    too_large = UserError(
        "{path}, sheet '{sheet}': larger than Excel's own sheets, or more than {most_cells:,} "
        "cells; expected a CSV file",
        path=path,
        sheet=sheet.title,
        most_cells=MOST_CELLS,
    )
    if _has_wide_row(text):
        raise too_large
    with _as_faults(path):
        parser = WorkSheetParser(
            io.BytesIO(text),
            sheet._shared_strings,  # noqa: SLF001
            data_only=True,
            epoch=book.epoch,
            date_formats=book._date_formats,  # noqa: SLF001
            timedelta_formats=book._timedelta_formats,  # noqa: SLF001
        )
        for number, stored in parser.parse():
            seen += len(stored)
            widest = max((cell["column"] for cell in stored), default=0)
            if seen > MOST_CELLS or number > MOST_ROWS or widest > MOST_COLUMNS:
                raise too_large
            values = {
                cell["column"]: cell["value"]
                for cell in stored
                if cell["value"] is not None and str(cell["value"]).strip()
            }
            if values:
                yield number, tuple(map(values.get, range(1, max(values) + 1)))


def _has_wide_row(text: bytes) -> bool:
    """Return whether a row in the XML of a sheet stores more cells than Excel has columns."""
    edges = [*(found.start() for found in ROW.finditer(text)), len(text)]
    return any(text.count(b"<c", *row) > MOST_COLUMNS for row in pairwise(edges))


@contextmanager
def _as_faults(path: Path) -> Iterator[None]:
    """Turn the errors of openpyxl and of the parsers below it into a `UserError`."""
    from openpyxl.utils.exceptions import InvalidFileException

    try:
        yield
    except (
        *(zipfile.BadZipFile, InvalidFileException, ParseError, KeyError, ValueError, TypeError),
        *(AttributeError, IndexError, OSError, NotImplementedError, EOFError, OverflowError),
    ) as error:
        raise UserError(
            "{path}: not a readable Excel workbook ({error}); save it as .xlsx or CSV UTF-8",
            path=path,
            error=error,
        ) from None


def _padded(row: tuple[object, ...], width: int) -> tuple[object, ...]:
    return row + (None,) * (width - len(row))


#: Programs with labelled values, and the function of pyreadstat that reads their files.
LABELLED = {
    ".sav": ("SPSS", "read_sav"),
    ".zsav": ("SPSS", "read_sav"),
    ".dta": ("Stata", "read_dta"),
}


def read_labelled(content: bytes, path: Path, wanted: Wanted) -> pd.DataFrame:
    """Read the cases in a file of SPSS or Stata, as text or numbers; ``line`` is the row number.

    In the columns with words, values are replaced by their labels ("female" instead of 2).

    Raises
    ------
    UserError
        If the file cannot be read.
    """
    import pyreadstat

    program, function = LABELLED[path.suffix.lower()]
    try:
        # The library reads files only.
        with TemporaryDirectory() as folder:
            file = Path(folder, f"table{path.suffix}")
            file.write_bytes(content)
            found, meta = getattr(pyreadstat, function)(str(file))
    except (pyreadstat.ReadstatError, pyreadstat.PyreadstatError, OSError, ValueError) as error:
        raise UserError(
            "{path}: not a readable {program} file ({error}); save it in {program} as {ending} or "
            "CSV",
            path=path,
            program=program,
            error=error,
            ending=path.suffix,
        ) from None
    frame = pd.DataFrame(index=found.index)
    for name in found.columns:
        labels = meta.variable_value_labels.get(name, {}) if name in wanted.words else {}
        cells = [as_cell(labels.get(value, value)) for value in found[name].tolist()]
        frame[name] = pd.Series(cells, dtype=object)
    return _with_lines(frame, list(range(1, len(frame) + 1)))


def _with_lines(frame: pd.DataFrame, lines: Sequence[int]) -> pd.DataFrame:
    return frame.assign(line=np.array(lines, np.int64))
