"""Split a table file into rows, with the line number of each row.

In well-formed files, the lines only need to be counted. Other files are processed line by line:
lines that are not rows are omitted and reported, and the rows keep their line numbers.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.reading.dialect import SEPARATORS
from slipscale.faults import UserError
from slipscale.faults.message import Message

QUOTE, NEWLINE = b'"', b"\n"
#: Text in quotation marks, and all characters that end no cell, keyed by separator.
QUOTED = re.compile(rb'"[^"]*"')
OTHERS = {mark.encode(): bytes(set(range(256)) - {*mark.encode(), *NEWLINE}) for mark in SEPARATORS}
#: Last line of a table from Gorilla, and its largest number of bytes.
END_OF_FILE = re.compile(rb'\n"?END OF FILE"?[,;\t]*\n*\Z')
LONGEST_END = 4096
#: Maximum number of line numbers to list in a sentence.
LISTED_LINES = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class Lines:
    """Header and rows of a table, as text.

    Parameters
    ----------
    header, body : bytes
        UTF-8 text with LF line endings and without a byte-order mark. ``body`` ends with a line
        ending.
    names : tuple of str
        Column names, without leading and trailing spaces and quotation marks.
    separator : str
    places : int array, shape (rows,)
        Line on which each row begins, counted from 1.
    left_out : tuple of str
        Descriptions of omitted lines.
    """

    header: bytes
    body: bytes
    names: tuple[str, ...]
    separator: str
    places: NDArray[np.int64]
    left_out: tuple[str, ...] = ()

    def renamed(self, new: Mapping[str, str]) -> Lines:
        """Rename the columns for which ``new`` has a name."""
        names = tuple(new.get(name, name) for name in self.names)
        if names == self.names:
            return self
        return replace(self, names=names, header=self.separator.join(names).encode())


def split(content: bytes, path: Path, separator: str, *, header: bool = True) -> Lines:
    """Split the content of a file into header and rows.

    Without a header, the names of the columns are 1, 2, 3 and so on.

    Raises
    ------
    UserError
        If the content is not UTF-8 text, is empty, has a line with a wrong number of cells, or has
        an unmatched quotation mark.
    """
    text = _checked(content, path)
    if END_OF_FILE.search(text, max(0, len(text) - LONGEST_END)):
        text = END_OF_FILE.sub(NEWLINE, text)
    unpadded = text.lstrip(NEWLINE)
    first = 1 + len(text) - len(unpadded)
    top, _, body = unpadded.partition(NEWLINE)
    if not top.strip():
        raise UserError("{path}: the file is empty; expected a header line and rows", path=path)
    if not header:
        first, body = first - 1, unpadded
        top = separator.join(map(str, range(1, 1 + len(_names(top, separator))))).encode()
    if top.count(QUOTE) % 2:
        raise UserError(
            "{path}: line {first}, the header, has an unmatched quotation mark; expected a pair"
            " around each quoted name",
            path=path,
            first=first,
        )
    names = _names(top, separator)
    if not body.endswith(NEWLINE) or body.endswith(2 * NEWLINE):
        body = body.rstrip(NEWLINE)
        body = body + NEWLINE if body else body
    count = _regular(top, body, separator, len(names))
    if count is not None:
        places = np.arange(first + 1, first + 1 + count)
        return Lines(header=top, body=body, names=names, separator=separator, places=places)
    return _row_by_row(top, body, names, separator=separator, first=first, path=path)


def complain(lines: Lines, path: Path) -> None:
    """Raise a `UserError` if any line is not a valid row."""
    first = int(lines.places[0]) - 1 if len(lines.places) else 1
    _row_by_row(
        lines.header, lines.body, lines.names, separator=lines.separator, first=first, path=path
    )


def _checked(content: bytes, path: Path) -> bytes:
    """Check that a file contains UTF-8 text, and return it as `plain` text."""
    try:
        _ = content.isascii() or content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(NEWLINE, 0, error.start) + 1
        raise UserError(
            "{path}: line {line} is not UTF-8 text; expected a text table (from Excel: save as "
            "'CSV UTF-8')",
            path=path,
            line=line,
        ) from error
    if b"\x00" in content:
        line = content.count(NEWLINE, 0, content.index(b"\x00")) + 1
        raise UserError(
            "{path}: line {line} contains a null byte; expected a text table", path=path, line=line
        )
    return plain(content)


def plain(content: bytes) -> bytes:
    """Convert line endings to LF, and remove a byte-order mark."""
    content = content.removeprefix(b"\xef\xbb\xbf")
    if b"\r" not in content:
        return content  # most tables; to search for one character takes no time
    return content.replace(b"\r\n", NEWLINE).replace(b"\r", NEWLINE)


@lru_cache
def _names(header: bytes, separator: str) -> tuple[str, ...]:
    # `split` reports unmatched quotation marks in the header.
    cells = next(csv.reader([header.decode("utf-8")], delimiter=separator, skipinitialspace=True))
    return tuple(name.strip(' "\t\ufeff') for name in cells)


def _regular(header: bytes, body: bytes, separator: str, cells: int) -> int | None:
    """Return the number of rows if all lines have as many cells as the header; otherwise None."""
    # Repeated headers and lines with only separators have the expected number of cells, but are not
    # data rows.
    line = header + NEWLINE
    if body.startswith(line) or NEWLINE + line in body or (body and _shortest(body) < cells):
        return None
    mark = separator.encode()
    outside = QUOTED.sub(b"", body) if QUOTE in body else body
    ends = outside.translate(None, OTHERS[mark])
    lines = len(ends) // cells
    return lines if ends == (mark * (cells - 1) + NEWLINE) * lines else None


def _shortest(body: bytes) -> int:
    """Return the number of characters of the shortest line; 0 if there are no lines."""
    ends = np.flatnonzero(np.frombuffer(body, np.uint8) == NEWLINE[0])
    return int(min(ends[:1].sum(), np.diff(ends).min(initial=len(body)) - 1))


def _row_by_row(
    header: bytes, body: bytes, names: Sequence[str], *, separator: str, first: int, path: Path
) -> Lines:
    """Omit and report empty lines and repeated headers; reject rows with wrong numbers of cells."""
    lines = body.split(NEWLINE)
    kept: list[bytes] = []
    places: list[int] = []
    empty: list[int] = []
    repeated: list[int] = []
    comments: list[int] = []
    trailing = 0
    for start, end, row in _rows(lines[:-1], separator, first, path):
        if not any(cell.strip() for cell in row):
            empty.append(start)
            trailing += 1
            continue
        trailing = 0
        if tuple(cell.strip() for cell in row) == names:
            repeated.append(start)
            continue
        if len(row) != len(names) and row[0].startswith("#"):
            comments.append(start)
            continue
        if len(row) != len(names):
            raise UserError(
                "{path}: line {start} {reason}",
                path=path,
                start=start,
                reason=_miscounted(len(row), names, separator),
            )
        kept += lines[start - first - 1 : end - first]
        places.append(start)
    # Empty lines after the last row are not reported, because many editors add them.
    empty = empty[: len(empty) - trailing]
    notes = [
        f"{listed_lines(found)}: {what}; skipped"
        for found, what in (
            (empty, "empty"),
            (repeated, "a repeated header"),
            (comments, "a comment"),
        )
        if found
    ]
    return Lines(
        header=header,
        body=b"".join(line + NEWLINE for line in kept),
        names=tuple(names),
        separator=separator,
        places=np.array(places, np.int64),
        left_out=tuple(notes),
    )


def _rows(
    lines: Sequence[bytes], separator: str, first: int, path: Path
) -> Iterator[tuple[int, int, list[str]]]:
    """Yield each row's first line number, last line number and cells."""
    reader = csv.reader(
        (line.decode("utf-8") + "\n" for line in lines),
        delimiter=separator,
        skipinitialspace=True,
        strict=True,
    )
    end = 0
    while True:
        start = end + 1
        try:
            row = next(reader)
        except StopIteration:
            return
        except csv.Error as error:
            raise UserError(
                "{path}: line {line} has an unmatched quotation mark, or text after one "
                "({error}); expected a pair around each quoted cell",
                path=path,
                line=first + start,
                error=error,
            ) from error
        end = reader.line_num
        yield first + start, first + end, row


def _miscounted(found: int, names: Sequence[str], separator: str) -> str:
    guess = (
        "check whether the file is truncated"
        if found < len(names)
        else Message(
            "check whether there is a '{separator}' inside a cell",
            separator=separator.replace("\t", "tab"),
        )
    )
    one = "has 1 cell, expected {expected} as in the header; {guess}"
    several = "has {found} cells, expected {expected} as in the header; {guess}"
    if found == 1:
        return Message(one, expected=len(names), guess=guess)
    return Message(several, found=found, expected=len(names), guess=guess)


def listed_lines(lines: Sequence[int]) -> str:
    """List up to `LISTED_LINES` line numbers, and the number of lines that are not listed.

    >>> listed_lines([3]), listed_lines([3, 5, 7])
    ('line 3', 'lines 3, 5 and 7')
    """
    if len(lines) == 1:
        return f"line {lines[0]}"
    cut = [str(line) for line in lines[:LISTED_LINES]]
    more = len(lines) - len(cut)
    last = f"{more} more" if more else cut.pop()
    return f"lines {', '.join(cut)} and {last}"
