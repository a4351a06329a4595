"""Read published tables from TOML or CSV files, and report all errors with line numbers."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

from pydantic import Field, ValidationError, model_validator

from slipscale.analysis.reconstruction.table.interval_column import IntervalColumn, interval_column
from slipscale.analysis.reconstruction.table.printed_tests import PrintedTest
from slipscale.analysis.reconstruction.table.published_table import (
    Column,
    Design,
    OpenScale,
    Summary,
    close,
    on_one_scale,
)
from slipscale.faults import UserError
from slipscale.faults.frozen_table import FrozenTable
from slipscale.faults.message import Message
from slipscale.faults.suggestions import expected_one_of
from slipscale.faults.toml_file import parse_toml
from slipscale.faults.toml_lines import Place
from slipscale.faults.validation import (
    Fault,
    Told,
    complaint,
    fault_at,
    faults_in,
    in_words,
    refuse,
    sentences,
)

SHIPPED = Path(__file__).parents[2] / "published"
# Prefix of the CSV columns that contain keys of the scale.
SCALE = "scale_"


@dataclass(frozen=True)
class PublishedTable:
    """A published table with its columns, design and published tests.

    A table contains either `columns` of discrete ratings or `intervals` for continuous values.
    """

    title: str
    columns: tuple[Column, ...]
    design: Design | None = None
    tests: tuple[PrintedTest, ...] = ()
    intervals: tuple[IntervalColumn, ...] = ()


@dataclass(frozen=True)
class Row:
    """A row of a CSV file, with its parsed column or its errors.

    Parameters
    ----------
    line : int
        Number of the line on which the row ends.
    cells : tuple of str
        Text of the cells, as in the file.
    column : Column or None
        The parsed column, or None if the row has errors.
    told : tuple of Told
        The errors.
    """

    line: int
    cells: tuple[str, ...]
    column: Column | None
    told: tuple[Told, ...] = ()


class _File(FrozenTable):
    title: str = ""
    design: Design | None = None
    scale: OpenScale = OpenScale()
    column: Annotated[tuple[Summary, ...], Field(min_length=1)]
    test: tuple[PrintedTest, ...] = ()

    @model_validator(mode="after")
    def _fits_together(self) -> _File:
        refuse(self._faults())
        return self

    def _faults(self) -> Iterator[Fault]:
        """Yield errors in entries that are valid separately, but not together."""
        kinds = {self.continuous(entry) for entry in self.column}
        if len(kinds) > 1:
            words = "discrete ratings and continuous values (or logarithms) need separate files"
            yield ("column",), {"msg": words}
        for place, entry in enumerate(self.column):
            try:
                (interval_column if self.continuous(entry) else close)(entry, self.scale)
            except ValueError as error:
                yield ("column", place), {"msg": said(error)}
        labels = self.labels()
        for place, test in enumerate(self.test):
            if test.of_two and not test.columns and len(labels) != 2:  # noqa: PLR2004 - a pair
                words = Message(
                    "expected the labels of the two columns that {kind} compares", kind=test.kind
                )
                yield ("test", place), {"msg": words}
            for label in test.columns:
                if label not in labels:
                    known = ", ".join(repr(known) for known in labels)
                    words = f"unknown column {label!r}; expected one or more of {known}"
                    yield ("test", place, "columns"), {"msg": words}

    def labels(self) -> list[str]:
        """Return the labels of all columns, using a default for each missing label."""
        return [entry.label or f"column {n}" for n, entry in enumerate(self.column, 1)]

    def continuous(self, entry: Summary) -> bool:
        """Return whether a column contains continuous values instead of discrete ratings."""
        return self.scale.continuous or entry.geometric_mean is not None

    def intervals(self) -> tuple[IntervalColumn, ...]:
        """Return the columns of continuous values."""
        return tuple(
            interval_column(entry.model_copy(update={"label": label}), self.scale)
            for entry, label in zip(self.column, self.labels(), strict=True)
            if self.continuous(entry)
        )

    def columns(self) -> tuple[Column, ...]:
        """Return the columns of discrete ratings, each with its scale."""
        if self.intervals():
            return ()
        closed = tuple(
            close(entry.model_copy(update={"label": label}), self.scale)
            for entry, label in zip(self.column, self.labels(), strict=True)
        )
        printed = self.scale.minimum is not None and self.scale.maximum is not None
        return closed if printed else on_one_scale(closed)


class _Line(Summary):
    """A row of a CSV file, including the scale of its column."""

    scale: OpenScale = OpenScale()


def said(error: ValueError) -> str:
    """Return the message of an error, or the messages of all errors that pydantic found."""
    if isinstance(error, ValidationError):
        return in_words(error)
    return str(error)


def read(path: Path) -> PublishedTable:
    """Read a published table from a TOML or CSV file, or read a supplied table by its name.

    Raises
    ------
    UserError
        If the table does not exist, cannot be read or is invalid.
    """
    if not path.exists() and path.name == str(path):
        # The name of a study also refers to its only table: biet2007 is biet2007_table3.
        named = [*SHIPPED.glob(f"{path}.toml")] or [*SHIPPED.glob(f"{path}_*.toml")]
        path = named[0] if len(named) == 1 else path
    text = _text_of(path)
    if path.suffix.lower() == ".csv":
        return from_csv(text, str(path), title=path.stem)
    return from_toml(text, str(path))


def read_rows(path: Path) -> list[Row]:
    """Read all rows of a CSV file, with error messages for rows that cannot be parsed.

    Raises
    ------
    UserError
        If the file cannot be read, is not CSV or has an incorrect header.
    """
    if path.suffix.lower() != ".csv":
        raise UserError(
            "{path}: expected a CSV file with one row per column of a published table", path=path
        )
    return _csv_rows(_text_of(path), str(path))


def _text_of(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        known = expected_one_of(path, sorted(p.stem for p in SHIPPED.glob("*.toml")))
        raise UserError(
            "{path}: cannot be read ({error}); expected a TOML or CSV file, or {known}",
            path=path,
            error=error,
            known=known,
        ) from None


def from_toml(text: str, source: str = "the table") -> PublishedTable:
    """Parse a published table from TOML text with ``[scale]``, ``[[column]]`` and ``[[test]]``."""
    # Numbers keep their decimals: 12.50 is read as "12.50".
    file = parse_toml(text, source, _File, parse_float=str)
    return PublishedTable(
        file.title, file.columns(), file.design, file.test, intervals=file.intervals()
    )


def from_csv(text: str, source: str = "the table", title: str = "") -> PublishedTable:
    """Parse a published table from CSV text with one row per column of the table.

    The header contains ``n`` and further keys of ``[[column]]`` in TOML files, such as ``mean`` and
    ``sd``. Keys of ``[scale]`` have the prefix ``scale_``, as in ``scale_maximum``. Empty cells are
    ignored. The separator in the header (comma, semicolon or tab) applies to all rows.
    """
    rows = _csv_rows(text, source)
    if faults := [fault for row in rows for fault in row.told]:
        raise complaint(source, faults)
    columns = tuple(row.column for row in rows if row.column is not None)
    open_scales = not any(column.scale_is_printed for column in columns)
    return PublishedTable(title, on_one_scale(columns) if open_scales else columns)


def _csv_rows(text: str, source: str) -> list[Row]:
    """Parse all rows below the header of a CSV file.

    Raises
    ------
    UserError
        If the text is not CSV, has no rows or has an incorrect header.
    """
    try:
        rows = list(_rows(text))
    except csv.Error as error:
        raise UserError("{source} is not CSV: {error}", source=source, error=error) from None
    if len(rows) < 2:  # noqa: PLR2004 - the header and a row
        raise UserError(
            "{source} has no rows; expected a header and one row per column", source=source
        )
    (first, header), *rows = rows
    names = [name.strip() for name in header]
    found = [_row(names, line, cells, place) for place, (line, cells) in enumerate(rows, 1)]
    if faults := [fault_at(first, (), words) for words in _wrong_names(names)]:
        raise complaint(source, faults + [fault for row in found for fault in row.told])
    return found


def _row(names: list[str], line: int, cells: list[str], place: int) -> Row:
    kept = tuple(cells)
    if len(cells) != len(names):
        counts = f"the header has {len(names)} cells, but the row has {len(cells)}"
        return Row(line, kept, None, (_at(line, counts),))
    entry = {name: c.strip() for name, c in zip(names, cells, strict=True) if c.strip()}
    try:
        return Row(line, kept, _from_row(entry, place))
    except ValidationError as error:
        return Row(line, kept, None, tuple(sentences(_of_row(error, names), partial(_line, line))))
    except ValueError as error:
        return Row(line, kept, None, (_at(line, error),))


def _at(line: int, message: object) -> Told:
    whole = Message("line {line}: {message}", line=line, message=message)
    return Told(line, (), whole, whole)


def _rows(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the non-empty rows of a CSV file, each with the number of its last line."""
    header = text.partition("\n")[0]
    # Decimal commas are possible if cells are separated by another character.
    delimiter = next((sign for sign in ";\t" if sign in header), ",")
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    for cells in reader:
        if any(cell.strip() for cell in cells):
            yield reader.line_num, cells


def _line(line: int, _place: Place) -> int:
    return line


def _wrong_names(names: list[str]) -> Iterator[str]:
    for name in dict.fromkeys(names):
        if name not in KNOWN:
            yield f"{name or 'a column without a name'}: expected one of {', '.join(KNOWN)}"
        elif names.count(name) > 1:
            yield f"{name}: occurs {names.count(name)} times, but must occur once"
    for name in NEEDED:
        if name not in names:
            yield f"{name}: is missing"


def _from_row(entry: Mapping[str, str], place: int) -> Column:
    own = {name: cell for name, cell in entry.items() if name in Summary.model_fields}
    scale = {name: entry[SCALE + name] for name in OpenScale.model_fields if SCALE + name in entry}
    line = _Line.model_validate({"label": f"column {place}", **own, "scale": scale})
    if line.scale.continuous or line.geometric_mean is not None:
        raise ValueError("continuous values and geometric means can only be read from TOML files")
    summary = Summary.model_construct(
        line.model_fields_set - {"scale"},
        **{name: getattr(line, name) for name in Summary.model_fields},
    )
    return close(summary, line.scale)


def _of_row(error: ValidationError, names: list[str]) -> Iterator[Fault]:
    """Yield the errors in one table row, with column names as in the header."""
    for place, fault in faults_in(error):
        of_scale = len(place) > 1 and place[0] == "scale"
        name = f"{SCALE}{place[1]}" if of_scale else str(place[0]) if place else ""
        if name in names or fault.get("type") != "missing":
            yield ((name,) if name else ()), fault


KNOWN = (*Summary.model_fields, *(SCALE + name for name in OpenScale.model_fields))
NEEDED = ("n",)
