"""Read a table that was written by hand or by another program, and number its lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from slipscale.analysis.reading.cleaning import tidied
from slipscale.analysis.reading.delimited import (
    MISSING,
    NOT_AVAILABLE,
    Problems,
    Source,
    check_names,
    filled,
    parse,
    read_source,
)
from slipscale.analysis.reading.dialect import (
    FALLBACK,
    Decimal,
    decimal_of,
    decoded,
    has_thousands_point,
    in_points,
    separated,
)
from slipscale.analysis.reading.programs.compressed import unpacked
from slipscale.analysis.reading.programs.records import as_text
from slipscale.analysis.reading.programs.table import program_of
from slipscale.analysis.reading.programs.wanted import Wanted
from slipscale.analysis.reading.suspicions import check_labels
from slipscale.analysis.reading.table_lines import Lines, complain, listed_lines, plain, split
from slipscale.faults import UserError

#: A number with a percent sign.
PERCENT = r"[+-]?[\d.,]+\s*%"
#: Codes that other programs use for missing identifiers. The BIDS code and blank cells always count
#: as missing.
NO_IDENTIFIER = tuple(name for name in NOT_AVAILABLE if name not in MISSING)


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """What is read from a table.

    Parameters
    ----------
    required : sequence of str
        Columns that the file must have.
    numbers, words : sequence of str
        Columns to return if present. Numbers are written with decimal points and without thousands
        separators; other cells are not changed.
    identifier : str or None
        Column with the participant's label. In this column, ``NA`` and similar codes count as
        missing unless they are quoted.
    decimal : str, optional
        Decimal mark; by default, detected from all numbers in the file.
    sheet : str, optional
        Sheet of a workbook, or variable in a MATLAB file.
    header : bool
        Whether the first line contains the names of the columns, which are otherwise 1, 2, 3.
    everything : bool
        Whether to return all columns; those that are not in ``words`` contain numbers.
    """

    required: Sequence[str] = ()
    numbers: Sequence[str] = ()
    words: Sequence[str] = ()
    identifier: str | None = None
    decimal: Decimal | None = None
    sheet: str | None = None
    header: bool = True
    everything: bool = False

    def numbers_of(self, names: Sequence[str]) -> Sequence[str]:
        """Return the columns of numbers in a table with the given columns."""
        return (
            [name for name in names if name not in self.words] if self.everything else self.numbers
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Opened:
    """A file, before its cells are converted.

    Parameters
    ----------
    path : Path
    source : Source
    table : DataFrame or Lines
        Cells of a file of one of the programs with their line numbers, or lines of a text table.
    quoted : bytes
        The text of the file if it contains quotation marks.
    """

    path: Path
    source: Source
    table: pd.DataFrame | Lines
    quoted: bytes = b""


def read_table(
    path: Path, request: Request, problems: Problems, root: Path | None = None
) -> tuple[pd.DataFrame, Source]:
    """Read a table and detect its encoding, separator and decimal mark.

    Parameters
    ----------
    path : Path
        A text file, or a file of one of the programs in
        `slipscale.analysis.reading.programs.table`.
    request : Request
    problems : Problems
        Collects the notes.
    root : Path, optional
        Folder to which the file's name is relative; by default, its own.

    Returns
    -------
    frame : DataFrame
        All rows, with the additional columns ``file`` (always 0) and ``line`` (counted from 1).
    source : Source

    Raises
    ------
    UserError
        See `slipscale.analysis.reading.delimited.read_tables`,
        `slipscale.analysis.reading.dialect.decimal_of` and the modules in
        `slipscale.analysis.reading.programs`.
    """
    opened = open_table(path, request, problems, root)
    return converted(opened, request, problems).assign(file=0), opened.source


def open_table(
    path: Path, request: Request, problems: Problems, root: Path | None = None
) -> Opened:
    """Read a file and check that it has the required columns; see `read_table`."""
    content, source = read_source(path, root if root and root.is_dir() else path.parent)
    content, inner = unpacked(content, path)
    program = program_of(content, inner)
    if program is not None:
        columns = None if request.everything else {*request.words, *request.numbers}
        wanted = Wanted(words=request.words, sheet=request.sheet, columns=columns)
        cells = program.read(content, inner, wanted)
        cells = cells if request.header else _without_header(cells)
        check_names([str(name) for name in cells if name != "line"], path, request.required)
        return Opened(path=path, source=source, table=cells)
    text, separator, above = separated(_as_utf_8(content, path, problems))
    if above:
        problems.add(f"{source.name}, {listed_lines(above)}: above the header; skipped")
    lines = split(text, path, separator, header=request.header)
    check_names(lines.names, path, request.required)
    for phrase in lines.left_out:
        problems.add(f"{source.name}, {phrase}")
    return Opened(path=path, source=source, table=lines, quoted=text if b'"' in text else b"")


def converted(
    file: Opened, request: Request, problems: Problems, cells: pd.DataFrame | None = None
) -> pd.DataFrame:
    """Return the requested columns of a file, whose ``cells`` may be parsed already."""
    table, name, identifier = file.table, file.source.name, request.identifier
    if isinstance(table, Lines):
        if cells is None:
            cells = cells_of([table], request, file.path, marked=is_marked(table))
        frame = cells
        numbers = request.numbers_of(filled(table.names))
        if request.everything and len(
            frame
        ):  # the comma at the end of each line of some programs is no column
            frame = frame.dropna(axis="columns", how="all")
    else:
        numbers = request.numbers_of([name for name in table.columns if name != "line"])
        frame = _only(table, numbers, request.words)
    _with_points(frame, numbers, request.decimal, name)
    if identifier is None:
        return frame
    quoted = _quoted_identifiers(frame, identifier, file.quoted)
    frame = only_named(frame, identifier, problems, name, quoted=quoted)
    who = [str(label) for label in frame[identifier].unique()]
    problems.add_many(check_labels(who, identifier, name), "labels that differ only in case")
    return frame


def _without_header(cells: pd.DataFrame) -> pd.DataFrame:
    """Return the cells with the first row, which the program took for the names of columns."""
    names = [name for name in cells.columns if name != "line"]
    numbered = dict(zip(names, map(str, range(1, len(names) + 1)), strict=True))
    if names == list(numbered.values()):  # the columns of a matrix have no names
        return cells
    first = pd.DataFrame([{**dict(zip(names, names, strict=True)), "line": 1}])
    return pd.concat([first, cells], ignore_index=True).rename(columns=numbered)


def _as_utf_8(content: bytes, path: Path, problems: Problems) -> bytes:
    text, encoding = decoded(content, path)
    if encoding == FALLBACK:
        problems.add(
            f"{path.name} is not UTF-8 and was read as Windows-1252; check names with accents"
        )
    return text


def _only(frame: pd.DataFrame, numbers: Sequence[str], words: Sequence[str]) -> pd.DataFrame:
    """Select the columns to read, and replace missing-value codes by NaN."""
    kept = frame[[*(name for name in (*words, *numbers) if name in frame), "line"]].copy()
    for name in kept.columns.drop("line"):
        signs = MISSING if name in words else NOT_AVAILABLE
        cells = kept[name].map(as_text).astype("str") if name in words else kept[name]
        kept[name] = cells.mask(cells.astype("str").str.strip().isin(signs))
    return kept


def is_marked(lines: Lines) -> bool:
    """Return whether a number could have a decimal comma, or separated thousands."""
    # If commas separate cells, only quoted cells can contain commas.
    mark = b"," if lines.separator != "," else b'"'
    return mark in lines.body or has_thousands_point(lines.body)


def cells_of(parts: Sequence[Lines], request: Request, path: Path, *, marked: bool) -> pd.DataFrame:
    """Parse the requested columns of tables with the same header, with the lines of their rows.

    ``marked`` tables have numbers that are read as text first, see `is_marked`.
    """
    names = filled(parts[0].names)
    numbers = request.numbers_of(names)
    try:
        frame = parse(
            parts,
            path,
            columns=(*request.words, *numbers),
            words=request.words,
            as_written=[name for name in numbers if name in names] if marked else (),
        )
    except UserError:
        complain(parts[0], path)
        raise
    frame["line"] = np.concatenate([lines.places for lines in parts])
    return frame


def _with_points(
    frame: pd.DataFrame, numbers: Sequence[str], decimal: Decimal | None, name: str
) -> None:
    """Rewrite all numbers in a file with decimal points.

    Cells that the program stored as numbers have no decimal mark. Only whole ones contribute to its
    detection: next to 540, the text 1.080 is ambiguous.
    """
    # Columns with only TRUE and FALSE are skipped, because `cleaning.numbers` rejects their cells.
    texts = [c for c in numbers if c in frame and frame[c].dtype in (object, "str")]
    for column in texts:
        frame[column] = _without_percent(frame[column])
    counts = {column: frame[column].value_counts() for column in texts}
    if decimal is None:
        decimal = decimal_of(
            {
                column: {
                    str(as_text(cell)): int(count)
                    for cell, count in cells.items()
                    if isinstance(cell, str) or str(as_text(cell)).isdigit()
                }
                for column, cells in counts.items()
            },
            name=name,
        )
    for column, cells in counts.items():
        written = {
            cell: in_points(cell, decimal) if isinstance(cell, str) else as_text(cell)
            for cell in cells.index
        }
        frame[column] = frame[column].map(written).astype("str")


def _without_percent(cells: pd.Series[Any]) -> pd.Series[Any]:
    """Remove the percent sign of all cells, if all numbers of a column have one."""
    given = cells.dropna().astype("str").str.strip()
    signed = given.str.fullmatch(PERCENT)
    return cells if given.empty or not signed.all() else given.str[:-1].reindex(cells.index)


def only_named(
    frame: pd.DataFrame,
    identifier: str,
    problems: Problems,
    name: str,
    *,
    quoted: NDArray[np.bool_],
) -> pd.DataFrame:
    """Select the rows with a participant label, and report the lines of all other rows.

    Parameters
    ----------
    frame : DataFrame
        Table with the column ``line`` and the column named by ``identifier``.
    name : str
        File name to use in messages.
    quoted : bool array, shape (rows,)
        Whether each row's identifier is in quotation marks in the file. ``NA`` in quotation marks
        is treated as a name.
    """
    tidy = _filled_down(tidied(frame[identifier]), name, problems)
    absent = tidy.cat.codes.to_numpy() < 0
    words = _are_no_identifier(tidy) & ~quoted
    if absent.any():
        lines = listed_lines(frame.loc[absent, "line"].tolist())
        problems.add(f"{name}, {lines}: omitted, because there is no {identifier}")
    if words.any():
        names = ", ".join(sorted({f"'{who}'" for who in tidy[words]}))
        lines = listed_lines(frame.loc[words, "line"].tolist())
        problems.add(
            f"{name}, {lines}: {identifier} is {names}, a usual code for missing values. "
            "The rows are omitted; if this is a name, put it in quotation marks"
        )
    kept = ~(absent | words)
    frame[identifier] = tidy
    return frame if kept.all() else frame[kept].reset_index(drop=True)


def _filled_down(labels: pd.Series[Any], name: str, problems: Problems) -> pd.Series[Any]:
    """Repeat labels that are only in the first row of each block, and report the number of rows."""
    codes = labels.cat.codes.to_numpy()
    at = np.flatnonzero(codes >= 0)
    blank = len(codes) - len(at)
    if not len(at) or at[0] or blank < len(at) or (np.diff(codes[at]) == 0).any():
        return labels
    problems.add(
        f"{name}: {labels.name} is only in the first row of each block, so the {blank} rows below "
        "are read as the same"
    )
    whole = np.repeat(codes[at], np.diff(at, append=len(codes)))
    filled_codes = pd.Categorical.from_codes(whole, labels.cat.categories)
    return pd.Series(filled_codes, index=labels.index, name=labels.name)


def _are_no_identifier(names: pd.Series[Any]) -> NDArray[np.bool_]:
    known = names.cat.categories.tolist()
    return np.array([*(name in NO_IDENTIFIER for name in known), False])[names.cat.codes]


def _quoted_identifiers(frame: pd.DataFrame, identifier: str, text: bytes) -> NDArray[np.bool_]:
    """Return whether each row's identifier is a missing-value code in quotation marks."""
    found = np.zeros(len(frame), bool)
    if not text:
        return found
    suspects = np.flatnonzero(_are_no_identifier(tidied(frame[identifier])))
    if not len(suspects):
        return found
    written = plain(text).split(b"\n")
    for row in suspects:
        name = str(frame[identifier].iloc[row]).strip().encode()
        found[row] = b'"' + name + b'"' in written[int(frame["line"].iloc[row]) - 1]
    return found
