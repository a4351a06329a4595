"""Many small tables of one kind, read in one go, with the place of every cell kept.

A study of thousands of participants is thousands of files; parsing them one by one costs mostly
start-up. Files with the same header are joined and parsed once; every row keeps the file and
the line it came from, so that a complaint can name them.
"""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from faults import UserError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from pydantic import ValidationError

MISSING = ["n/a", ""]
LISTED_PROBLEMS = 12
#: Characters of a list of column names in a message: a foreign file's first line may be long.
LONGEST_LIST = 400
#: A number above this is a slip, and its square no longer one.
LARGEST = 1e100


@dataclass(slots=True)
class Problems:
    """Sentences on what is wrong with the data; long lists are cut, and say so."""

    sentences: list[str] = field(default_factory=list)

    def add(self, sentence: str) -> None:
        """Note one sentence."""
        self.sentences.append(sentence)

    def add_many(self, sentences: Sequence[str], what: str) -> None:
        """Note sentences of one kind: the first dozen in full, then how many more."""
        self.sentences.extend(sentences[:LISTED_PROBLEMS])
        if len(sentences) > LISTED_PROBLEMS:
            more = len(sentences) - LISTED_PROBLEMS
            self.sentences.append(f"... and {more} more of this kind ({what})")


@dataclass(frozen=True, slots=True)
class Source:
    """One file as it was read: its name in the data set, and the SHA-256 of its bytes."""

    name: str
    sha256: str


def read_bytes(path: Path) -> bytes:
    """Return a file's bytes, or say in a sentence why not."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({error.strerror})") from error


def digest(content: bytes) -> str:
    """Return the SHA-256 of a file's content, in hexadecimal."""
    return hashlib.sha256(content).hexdigest()


def read_tables(
    paths: Sequence[Path],
    root: Path,
    *,
    separator: str = "\t",
    decimal: str = ".",
    required: Sequence[str] = (),
) -> tuple[pd.DataFrame, list[Source]]:
    """Read tables of one kind into one frame.

    Parameters
    ----------
    paths : sequence of Path
        The files, with a header line each; columns may differ between files.
    root : Path
        The data set's folder; files are named relative to it.
    separator, decimal : str
        One character each.
    required : sequence of str
        Columns that every file must have.

    Returns
    -------
    frame : DataFrame
        All rows, with the columns ``file`` (index into ``paths``) and ``line`` (1 is the header).
    sources : list of Source
        The files in the order of ``paths``.

    Raises
    ------
    UserError
        A file cannot be read, is not UTF-8, is empty, or has a line with too few or many
        cells, lacks a required column, or has a column twice.
    """
    sources: list[Source] = []
    plain: dict[bytes, list[tuple[int, bytes, int]]] = {}
    frames: list[pd.DataFrame] = []
    for number, path in enumerate(paths):
        content = read_bytes(path)
        sources.append(Source(_name(path, root), digest(content)))
        header, body = _split(content, path)
        _check_header(header, path, separator, required)
        if b'"' in content:
            frame = _parse(header + b"\n" + body, path, separator, decimal)
            frames.append(frame.assign(file=number, line=np.arange(2, len(frame) + 2)))
            continue
        lines = body.count(b"\n")
        cells = header.count(separator.encode()) + 1
        if body.count(separator.encode()) != lines * (cells - 1):
            _name_ragged_line(body, separator.encode(), cells, path)
        plain.setdefault(header, []).append((number, body, lines))
    for header, group in plain.items():
        joined = header + b"\n" + b"".join(body for _, body, _ in group)
        culprit = paths[group[0][0]] if len(group) == 1 else root
        frame = _parse(joined, culprit, separator, decimal)
        counts = [lines for _, _, lines in group]
        frame["file"] = np.repeat([number for number, _, _ in group], counts)
        frame["line"] = np.concatenate([np.arange(2, lines + 2) for lines in counts])
        frames.append(frame)
    frames = [frame for frame in frames if len(frame)] or frames[:1]
    everything = pd.concat(frames, ignore_index=True) if len(frames) > 1 else frames[0]
    if len(frames) > 1:
        everything = everything.sort_values(["file", "line"], ignore_index=True)
    return everything, sources


def _name(path: Path, root: Path) -> str:
    return path.relative_to(root).as_posix() if path.is_relative_to(root) else path.name


def _split(content: bytes, path: Path) -> tuple[bytes, bytes]:
    """Return the header line and the rest, without byte-order mark, with plain line ends."""
    try:
        content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise UserError(
            f"{path}: line {line} is not UTF-8 text; expected a text table "
            "(from Excel: save as 'CSV UTF-8')"
        ) from error
    if b"\x00" in content:
        line = content.count(b"\n", 0, content.index(b"\x00")) + 1
        raise UserError(f"{path}: line {line} holds a null byte; expected a text table")
    text = content.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    header, _, body = text.partition(b"\n")
    if not header.strip():
        raise UserError(f"{path}: the file is empty; expected a header line and rows")
    body = body.rstrip(b"\n")
    return header, body + b"\n" if body else body


def _check_header(header: bytes, path: Path, separator: str, required: Sequence[str]) -> None:
    names = [name.strip(' "') for name in header.decode("utf-8").split(separator)]
    if doubled := sorted({name for name in names if name and names.count(name) > 1}):
        raise UserError(f"{path}: column {', '.join(doubled)} is there twice; expected it once")
    if missing := [name for name in required if name not in names]:
        raise UserError(f"{path}: no column {', '.join(missing)}; found {_cut(names)}")


def _cut(names: Sequence[str]) -> str:
    """Return column names for a message, no longer than a few lines."""
    listed = ", ".join(names)
    return listed if len(listed) <= LONGEST_LIST else f"{listed[:LONGEST_LIST]} ..."


def _name_ragged_line(body: bytes, separator: bytes, cells: int, path: Path) -> None:
    for number, line in enumerate(body.split(b"\n")[:-1], start=2):
        found = line.count(separator) + 1
        if found != cells:
            if not line.strip():
                raise UserError(f"{path}: line {number} is empty; expected {cells} cells")
            raise UserError(
                f"{path}: line {number} has {found} cells, expected {cells} as in the header; "
                "is the file truncated?"
            )


def _parse(text: bytes, path: Path, separator: str, decimal: str) -> pd.DataFrame:
    try:
        frame = pd.read_csv(
            io.BytesIO(text),
            sep=separator,
            decimal=decimal,
            na_values=MISSING,
            keep_default_na=False,
            skip_blank_lines=False,
            low_memory=False,
            dtype={"participant_id": "str"},  # 01 is a name, not a number
        )
    except (pd.errors.ParserError, pd.errors.EmptyDataError, ValueError) as error:
        raise UserError(f"{path}: not a table that can be read ({error})") from error
    frame.columns = frame.columns.str.strip()
    # PsychoPy ends each line with a comma: a column without a name and without values.
    unnamed = [
        name for name in frame.columns if name.startswith("Unnamed:") and frame[name].isna().all()
    ]
    return frame.drop(columns=unnamed)


def require(frame: pd.DataFrame, columns: Sequence[str], where: str) -> None:
    """Raise a `UserError` that names every column that is missing."""
    missing = [name for name in columns if name not in frame.columns]
    if missing:
        found = _cut([name for name in frame.columns if name not in ("file", "line")])
        raise UserError(
            f"{where}: no column {', '.join(missing)}; found {found}. "
            f"Expected at least {', '.join(columns)}"
        )


def places(rows: pd.DataFrame, sources: Sequence[Source]) -> list[str]:
    """Return "file, line n" for each row."""
    pairs = zip(rows["file"].tolist(), rows["line"].tolist(), strict=True)
    return [f"{sources[int(number)].name}, line {line}" for number, line in pairs]


def numbers(
    frame: pd.DataFrame,
    column: str,
    sources: Sequence[Source],
    problems: Problems,
    *,
    minimum: float = -np.inf,
    lost: str = "the trial",
) -> pd.Series[float]:
    """Return a column as numbers; what is not one becomes missing and is named in ``problems``.

    Parameters
    ----------
    minimum : float
        Smaller values, and those above `LARGEST`, are named and become missing too.
    lost : str
        What is left out where the cell cannot be read.
    """
    raw = frame[column]
    values = (
        raw.astype(float)
        if pd.api.types.is_numeric_dtype(raw) and not pd.api.types.is_bool_dtype(raw)
        else pd.to_numeric(raw.astype("object"), errors="coerce").astype(float)
    )
    text = values.isna() & raw.notna()
    outside = values.notna() & ~((values >= minimum) & (values <= LARGEST))
    for bad, expected in (
        (text, "a number"),
        (outside, f"a number of {minimum:g} or more, at most {LARGEST:g},"),
    ):
        if not bad.any():
            continue
        problems.add_many(
            [
                f"{place}, column {column}: '{value}' where {expected}{_hint(value)} was expected; "
                f"{lost} is left out"
                for place, value in zip(places(frame[bad], sources), raw[bad], strict=True)
            ],
            f"column {column}",
        )
    return values.mask(outside)


def _hint(value: object) -> str:
    return " with a decimal point" if "," in str(value) else ""


def faults_of(error: ValidationError) -> str:
    """Return every fault that pydantic found: where, and what was expected."""
    return "; ".join(
        f"{'.'.join(str(part) for part in fault['loc'])}: {fault['msg']}"
        for fault in error.errors()
    )
