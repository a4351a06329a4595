"""Read many small tables of the same kind, and record the file and line of each row.

To avoid the overhead of parsing thousands of files separately, files with the same header are
joined and parsed together.
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
import shlex
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

import numpy as np
import pandas as pd
from pydantic import ValidationError

from slipscale.analysis.reading.own_results import refuse_copy
from slipscale.analysis.reading.table_lines import Lines, complain, split
from slipscale.analysis.reading.trial_tables import FREE_TEXT
from slipscale.experiments.dataset.schema import MISSING as NO_VALUE
from slipscale.experiments.dataset.schema import SIDECAR
from slipscale.experiments.journal.serialisation import QUANTITY
from slipscale.faults import UserError
from slipscale.faults.message import joined
from slipscale.faults.toml_lines import Lines as TomlLines
from slipscale.faults.validation import faults_in, sentences
from slipscale.stimuli.level_names import UNKNOWN
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity
from slipscale.stimuli.quantity_table import QuantityTable

#: Codes for missing cells in all columns: the BIDS code and an empty cell.
MISSING = ("", NO_VALUE)
#: Codes for missing numbers, as written by R, pandas, NumPy, Excel and databases.
NOT_AVAILABLE = (
    *MISSING,
    *("NA", "N/A", "#N/A", "<NA>", "NaN", "nan", "-nan", "NULL", "Null", "null", "None", "none"),
)
#: Columns that contain names and words, including the columns of a codebook.
TEXT = (*FREE_TEXT, "coder", "category")
LISTED_PROBLEMS = 12
#: Path that stands for standard input.
STANDARD_INPUT = Path("-")
#: Contents of tables that are no files, keyed by the path that stands for them.
_HELD: ContextVar[Mapping[Path, bytes]] = ContextVar("held")
#: Number of bytes to parse at once.
PART_BYTES = 8_000_000
#: Numeric column types, which may differ between parts of a table.
NUMBERS = ("int64", "float64")
#: Maximum total length of column names in a message.
LONGEST_LIST = 400


@dataclass(slots=True)
class Problems:
    """Descriptions of errors in the data. Long lists of errors are shortened."""

    sentences: list[str] = field(default_factory=list)
    #: Names of columns in the file, keyed by Slipscale's names, if different.
    titles: Mapping[str, str] = field(default_factory=dict)
    #: Quantity in the names of other columns.
    quantity: Quantity = PLATE_AMPLITUDE

    def title(self, column: str) -> str:
        """Return the name that a column has in the file."""
        return self.titles.get(column) or self.quantity.named(column)

    def add(self, sentence: str) -> None:
        """Add a description of an error."""
        self.sentences.append(sentence)

    def add_many(self, sentences: Sequence[str], what: str, total: int | None = None) -> None:
        """Record the first `LISTED_PROBLEMS` of several similar problems, and count the others.

        ``total`` is the number of all problems, if ``sentences`` does not describe all of them.
        """
        self.sentences.extend(sentences[:LISTED_PROBLEMS])
        more = (len(sentences) if total is None else total) - LISTED_PROBLEMS
        if more > 0:
            self.sentences.append(f"... and {more} more of this kind ({what})")


@dataclass(frozen=True, slots=True)
class Source:
    """Name and SHA-256 of an input file."""

    name: str
    sha256: str


@contextmanager
def held(contents: Mapping[Path, bytes]) -> Iterator[None]:
    """Let paths stand for tables in memory while they are read."""
    token = _HELD.set(contents)
    try:
        yield
    finally:
        _HELD.reset(token)


def read_bytes(path: Path, most: int = -1) -> bytes:
    """Read a file or a held table, or its first ``most`` bytes; raise UserError if this fails."""
    if (content := _HELD.get({}).get(path)) is not None:
        return content if most < 0 else content[:most]
    try:
        with path.open("rb") as file:
            return file.read(most)
    except OSError as error:
        raise UserError(
            "{path}: cannot be read ({reason}); expected a file that you may read",
            path=path,
            reason=error.strerror,
        ) from error


def digest(content: bytes) -> str:
    """Return the SHA-256 of a file's content in hexadecimal."""
    return hashlib.sha256(content).hexdigest()


def read_source(path: Path, root: Path) -> tuple[bytes, Source]:
    """Read a file, and return its bytes and a `Source` with its name and SHA-256."""
    content = read_bytes(path)
    return content, Source(_name(path, root), digest(content))


def read_tables(
    paths: Sequence[Path],
    root: Path,
    *,
    separator: str = "\t",
    required: Sequence[str] = (),
    columns: Sequence[str] = (),
    problems: Problems | None = None,
) -> tuple[pd.DataFrame, list[Source]]:
    """Read tables of one kind into a single frame.

    Parameters
    ----------
    paths : sequence of Path
        Files with a header line. Columns may differ between files.
    root : Path
        The data set folder, to which file names are relative.
    separator : str
        One character.
    required : sequence of str
        Columns that every file must have.
    columns : sequence of str
        Columns to return if present; if empty, all columns are returned. ``NA`` and similar codes
        count as missing in the given columns, except in `TEXT`.
    problems : Problems, optional
        Collects notes on omitted lines: empty lines and repeated headers between rows.

    Returns
    -------
    frame : DataFrame
        All rows, with the columns ``file`` (index into ``paths``) and ``line`` (1 is the header).
    sources : list of Source
        The files, in the same order as ``paths``.

    Raises
    ------
    UserError
        If a file cannot be read, is not UTF-8, is empty, lacks a required column, has a duplicate
        column, or has a line with a wrong number of cells.
    """
    sources: list[Source] = []
    groups: dict[bytes, list[tuple[int, Lines]]] = {}
    checked: set[tuple[str, ...]] = set()
    known = {*required, *columns}
    for number, path in enumerate(paths):
        content, source = read_source(path, root)
        sources.append(source)
        lines = split(content, path, separator)
        quantity = quantity_of(path)
        in_names, in_files = quantity.in_code, quantity.in_file
        if lines.names not in checked:
            check_names(lines.names, path, [in_files[name] for name in required])
            checked.add(lines.names)
        # Other columns, such as a factor's, keep their names.
        codes = {name: in_names[name] for name in lines.names}
        codes = {name: code for name, code in codes.items() if code.removesuffix(UNKNOWN) in known}
        lines = lines.renamed(codes)
        if problems is not None:
            for phrase in lines.left_out:
                problems.add(f"{source.name}, {phrase}")
        # Files with quotation marks are parsed separately, so that no quotation extends into the
        # next file.
        alone = str(number).encode() if b'"' in lines.body else b""
        groups.setdefault(lines.header + b"\n" + alone, []).append((number, lines))
    frames = [_read_group(group, paths, columns) for group in groups.values()]
    frames = [frame for frame in frames if len(frame)] or frames[:1]
    everything = pd.concat(frames, ignore_index=True) if len(frames) > 1 else frames[0]
    if len(frames) > 1:
        everything = everything.sort_values(["file", "line"], ignore_index=True)
    return everything, sources


def header_of(path: Path) -> list[str]:
    """Return the names of a TSV file's columns, as in the file."""
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as stream:
        return next(csv.reader(stream, delimiter="\t"), [])


def quantity_of(path: Path) -> Quantity:
    """Return the quantity of a table's levels from its sidecar; by default, amplitude in µm."""
    sidecar = path.with_suffix(".json")
    if not path.name.endswith("_beh.tsv") or not sidecar.is_file():
        return PLATE_AMPLITUDE
    content = read_bytes(sidecar)
    if QUANTITY.encode() not in content:
        return PLATE_AMPLITUDE
    try:
        stated = json.loads(content)[SIDECAR].get(QUANTITY)
        return QuantityTable.model_validate(stated or {}).quantity
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        raise UserError(
            "{sidecar}: {key} cannot be read; expected name, unit and convention, as in the "
            "study file",
            sidecar=sidecar,
            key=QUANTITY,
        ) from None


def _read_group(
    group: Sequence[tuple[int, Lines]], paths: Sequence[Path], columns: Sequence[str]
) -> pd.DataFrame:
    """Read and join files with the same header; add columns for the file and line of each row."""
    first = group[0][0]

    def parsed(part: Sequence[tuple[int, Lines]]) -> pd.DataFrame:
        return parse([lines for _, lines in part], paths[first], columns=columns)

    try:
        frame = _joined([parsed(part) for part in _parts(group)])
        # If a column's type differs between parts, the whole table is parsed at once.
        frame = parsed(group) if frame is None else frame
    except UserError:
        for number, lines in group:
            complain(lines, paths[number])
        raise
    places = {
        "file": np.repeat(
            [number for number, _ in group], [len(lines.places) for _, lines in group]
        ),
        "line": np.concatenate([lines.places for _, lines in group]),
    }
    return pd.concat([frame, pd.DataFrame(places, index=frame.index)], axis=1)


def _parts(group: Sequence[tuple[int, Lines]]) -> list[list[tuple[int, Lines]]]:
    """Split files into parts of about `PART_BYTES`, to limit the memory that pandas needs."""
    parts: list[list[tuple[int, Lines]]] = [[]]
    size = 0
    for entry in group:
        if size >= PART_BYTES:
            parts.append([])
            size = 0
        parts[-1].append(entry)
        size += len(entry[1].body)
    return parts


def _joined(frames: list[pd.DataFrame]) -> pd.DataFrame | None:
    """Concatenate parts of a table; return None if a column's type differs between parts.

    A column with integers in one part and decimals in another becomes a column of decimals.
    """
    kinds = [["number" if kind in NUMBERS else str(kind) for kind in f.dtypes] for f in frames]
    if any(other != kinds[0] for other in kinds):
        return None
    return pd.concat(frames, ignore_index=True) if len(frames) > 1 else frames[0]


def _name(path: Path, root: Path) -> str:
    try:
        return path.relative_to(root).as_posix()
    except ValueError:
        return path.name


def check_names(names: Sequence[str], path: Path, required: Sequence[str]) -> None:
    """Raise a `UserError` if a required column is missing or a column occurs twice."""
    if duplicates := sorted({name for name in names if name and names.count(name) > 1}):
        raise UserError(
            "{path}: column {duplicates} occurs twice; expected only one column with this name",
            path=path,
            duplicates=", ".join(duplicates),
        )
    if missing := [name for name in required if name not in names]:
        refuse_copy(names, path)
        near = [
            f"{guess[0]} for {name}"
            for name in missing
            if (guess := get_close_matches(name, [n for n in names if n], n=1))
        ]
        nearest = f"Nearest: {', '.join(near)}. " if near else ""
        raise UserError(
            "{path}: no column {missing}; found {columns}. {nearest}Expected at least "
            "{required}; for a description of the columns and a proposal, run {command}",
            path=path,
            missing=", ".join(missing),
            columns=_cut(names),
            nearest=nearest,
            required=", ".join(required),
            command=shlex.join(["slipscale", "analyse", str(path)]),
        )


def filled(names: Sequence[str]) -> list[str]:
    """Return the names of columns, with a name for each column that has none."""
    return [name or f"unnamed {place}" for place, name in enumerate(names)]


def _cut(names: Sequence[str]) -> str:
    """Join column names for a message, and truncate long lists."""
    listed = ", ".join(" ".join(name.split()) for name in names if name) or "no names"
    return listed if len(listed) <= LONGEST_LIST else f"{listed[:LONGEST_LIST]} ..."


def parse(
    parts: Sequence[Lines],
    path: Path,
    *,
    columns: Sequence[str],
    words: Collection[str] = TEXT,
    as_written: Collection[str] = (),
) -> pd.DataFrame:
    """Parse rows; return all columns, or only ``columns`` if given, in the order of the file.

    ``parts`` are files with the same header. Columns in ``words`` and ``as_written`` are read as
    text. In ``words``, only empty cells and the BIDS code for missing values count as missing.
    """
    sample, separator = parts[0], parts[0].separator
    names = filled(sample.names)
    text = b"".join([sample.header, b"\n", *(lines.body for lines in parts)])
    # Every row is known to have as many cells as the header, which pandas does not check then.
    wanted = [name for name in columns if name in names]
    missing = {name: NOT_AVAILABLE if name in columns else MISSING for name in names}
    missing |= dict.fromkeys(words, MISSING)
    try:
        frame = pd.read_csv(
            io.BytesIO(text),
            sep=separator,
            header=0,
            names=names,
            usecols=wanted if columns else None,
            na_values={name: list(missing[name]) for name in (wanted if columns else names)},
            keep_default_na=False,
            # Files edited by hand often have spaces between separators and quotation marks.
            skipinitialspace=b" " in text and separator.encode() + b" " in text,
            low_memory=False,
            dtype=dict.fromkeys([*words, *as_written], "str"),
        )
        if len(frame) != sum(len(lines.places) for lines in parts):
            raise ValueError("expected one row on each line")  # noqa: TRY301 - as pandas does
    except (pd.errors.ParserError, ValueError) as error:
        raise UserError(
            "{path}: not a readable table ({error}); expected a header line and rows with as many "
            "cells; save it as CSV UTF-8",
            path=path,
            error=error,
        ) from error
    if columns:
        return frame
    # PsychoPy ends each line with a comma, which creates a column without a name or values.
    unnamed = [
        name
        for name, given in zip(names, sample.names, strict=True)
        if not given and frame[name].isna().all()
    ]
    return frame.drop(columns=unnamed)


def faults_of(error: ValidationError, text: str, within: tuple[str, ...] = ()) -> str:
    """Describe all errors that pydantic found in a TOML text, with line and expected value.

    If only one table of the document was validated, such as ``[analysis]``, ``within`` is its key.
    """
    faults = [((*within, *place), fault) for place, fault in faults_in(error)]
    return joined("; ", (each.whole for each in sentences(faults, TomlLines(text).of)))
