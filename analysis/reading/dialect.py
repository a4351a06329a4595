"""Detect a table's format: encoding, separator, decimal mark and thousands separators.

The format is detected once per file from all numbers, so that an invalid cell does not affect the
interpretation of other cells. Ambiguous numbers are rejected unless other numbers in the file
resolve the ambiguity.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import islice, pairwise
from pathlib import Path
from typing import Literal

import numpy as np

from slipscale.faults import UserError

Decimal = Literal[".", ","]
#: Possible separators, in order of preference.
SEPARATORS = ("\t", ";", ",", "|")
#: Ends of lines, and the number of lines in which two with cells are searched.
LINES, FIRST = re.compile(rb"\r\n|\n|\r"), 20
#: A line that is not blank.
FILLED = re.compile(rb"[^\r\n]*[^\s][^\r\n]*")
#: A quoted cell, or blanks between cells.
BLANKS = re.compile(rb'("[^"]*")|[ ]+')
#: Beginnings of Unicode text. That of UTF-32 begins with that of UTF-16.
BOMS = {
    **dict.fromkeys((b"\xff\xfe\0\0", b"\0\0\xfe\xff"), "utf-32"),
    **dict.fromkeys((b"\xff\xfe", b"\xfe\xff"), "utf-16"),
    b"\xef\xbb\xbf": "utf-8-sig",
}
#: Number of first bytes in which null bytes are counted, because every second byte of Latin text in
#: UTF-16 is one; smallest proportion of them at these places, and largest at the others.
WIDE, MOST_WIDE, FEW_WIDE = 4096, 0.5, 0.1
#: Beginning of a line of comments.
COMMENT = re.compile(rb'\s*"?(#|%|//)\s*')
#: Characters of lines without content.
BLANK = b' \t,;|"'
#: Line between the header and the rows of a table in Markdown.
RULE = re.compile(rb"[\s|:+-]+")
#: First line that tells Excel the separator, which is detected from the header instead.
HINT = re.compile(r"\A\ufeff?\"?sep=.\"?(?=\r?\n)", re.IGNORECASE)
LONGEST_HINT = 8
#: Default encoding of Excel on Windows in Western Europe.
FALLBACK = "cp1252"

_TAIL = r"(?:[eE][+-]?\d+)?"
#: Spaces and apostrophes may separate thousands, whatever the decimal mark.
_GAPS = r"[ '\u2019\u00a0\u202f]"


def _certain(mark: str, other: str) -> re.Pattern[str]:
    """Return a pattern for numbers that identify ``mark`` as the decimal mark."""
    m, o = re.escape(mark), re.escape(other)
    forms = (
        rf"\d*{m}(?:\d{{1,2}}|\d{{4,}})?",  # 0,5 but not 1,000
        rf"(?:0*|\d{{4,}}){m}\d+",  # 0,500 and 1234,500
        rf"\d{{1,3}}(?:{o}\d{{3}})+{m}\d+",  # 1.234,500
        rf"\d{{1,3}}(?:{o}\d{{3}}){{2,}}",  # 1.234.567
        rf"\d{{1,3}}(?:{_GAPS}\d{{3}})+{m}\d+",  # 1 234,500
        rf"\d+{m}\d+[eE][+-]?\d+",  # 1,500e3
    )
    return re.compile(rf"(?=.*\d)[+-]?(?:{'|'.join(forms)}){_TAIL}")


CERTAIN: dict[Decimal, re.Pattern[str]] = {".": _certain(".", ","), ",": _certain(",", ".")}
AMBIGUOUS = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}")
#: Number of bytes in which points are searched at once, and of bytes to both sides of a point that
#: decide what it separates.
PART, REACH = 2**20, 5


def has_thousands_point(text: bytes) -> bool:
    """Return whether a point is between one to three digits and three digits, as in 1.080.

    The first digit must not be 0. All bytes are compared at once, because a regular expression
    would be tried at every point of the table.
    """
    padded = b" " * REACH + text + b" " * REACH
    return any(
        _points_apart(padded[begin : begin + PART + 2 * REACH])
        for begin in range(0, len(text) if b"." in text else 0, PART)
    )


def _points_apart(text: bytes) -> bool:
    """Return whether a point separates thousands, except in the first and last `REACH` bytes."""
    found = np.frombuffer(text, np.uint8)
    digit, point = found - ord("0") < 10, found == ord(".")  # noqa: PLR2004 - wraps below 0
    inside = digit | point
    three = digit[6:-4] & digit[7:-3] & digit[8:-2] & ~inside[9:-1]
    at = REACH + np.flatnonzero(point[5:-5] & digit[4:-6] & three)
    # The number before the point has one, two or three digits.
    size = 1 + digit[at - 2] * (1 + digit[at - 3])
    return bool((~inside[at - size - 1] & (found[at - size] != ord("0"))).any())


def in_points(cell: str, decimal: Decimal) -> str:
    """Write a number with a decimal point and without thousands separators.

    Thousands may be separated by spaces, apostrophes, or the comma or point that is not the decimal
    mark. Cells that are not numbers are not changed.

    >>> in_points("1.234,5", ",")
    '1234.5'
    """
    other = "." if decimal == "," else ","
    text = cell.strip()
    form = (
        rf"[+-]?(?:\d+|[1-9]\d{{0,2}}(?:(?:{re.escape(other)}|{_GAPS})\d{{3}})+)?"
        rf"(?:{re.escape(decimal)}\d*)?{_TAIL}"
    )
    if not re.fullmatch(form, text) or not any(mark.isdigit() for mark in text):
        return cell
    return re.sub(rf"{re.escape(other)}|{_GAPS}", "", text).replace(decimal, ".")


def decoded(content: bytes, path: Path) -> tuple[bytes, str]:
    """Convert a text file's content to UTF-8; return it with the name of its original encoding.

    The content is decoded as UTF-8, as UTF-16 or UTF-32 if it has a byte-order mark, as UTF-16 if
    every second byte is null, or otherwise as Windows-1252.

    Raises
    ------
    UserError
        If the content is in none of these encodings.
    """
    null = b"\0" in content
    if content.isascii() and not null and b"sep=" not in content[:LONGEST_HINT].lower():
        return content, "utf-8"  # most tables are; nothing is copied
    marked = (name for mark, name in BOMS.items() if content.startswith(mark))
    encoding = next(marked, _wide(content) if null else "utf-8")
    try:
        return _without_hint(content.decode(encoding)).encode("utf-8"), encoding
    except UnicodeError as error:
        start = error.start if isinstance(error, UnicodeDecodeError) else 0
    # Null bytes and byte-order marks do not occur in Windows-1252.
    if encoding == "utf-8" and not null:
        try:
            return _without_hint(content.decode(FALLBACK)).encode("utf-8"), FALLBACK
        except UnicodeDecodeError:
            pass
    line = content.count(b"\n", 0, start) + 1
    expected = encoding.removesuffix("-sig").upper()
    raise UserError(
        "{path}: line {line} is not {expected} text; expected a text table (from Excel: save as"
        " 'CSV UTF-8')",
        path=path,
        line=line,
        expected=expected,
    )


def _wide(content: bytes) -> str:
    """Return the encoding of text with null bytes and without a byte-order mark."""
    even, odd = (content[first:WIDE:2] for first in (0, 1))
    shares = [half.count(0) / max(len(half), 1) for half in (even, odd)]
    if max(shares) < MOST_WIDE or min(shares) > FEW_WIDE:
        return "utf-8"
    return "utf-16-be" if shares[0] > shares[1] else "utf-16-le"


def _without_hint(text: str) -> str:
    """Empty a first line such as ``sep=;``, which tells Excel the separator.

    The line stays, so that line numbers in messages are those of the file.
    """
    return HINT.sub("", text, count=1)


def separator_of(text: bytes) -> str:
    """Detect the separator in the first line, ignoring characters inside quotes."""
    header = next((_outside(line) for line in _filled_lines(text, 1)), b"")
    return next((mark for mark in SEPARATORS if mark.encode() in header), ",")


def _filled_lines(text: bytes, most: int) -> list[bytes]:
    """Return the first lines that are not blank, without a copy of the others."""
    return [found[0] for found in islice(FILLED.finditer(text), most)]


def separated(text: bytes) -> tuple[bytes, str, list[int]]:
    """Return a table's text, its separator and the numbers of the lines above its header.

    These lines (comments and titles) are emptied. Runs of blanks become tabs. A table is separated
    by blanks if its first line has no other separator, and its second line has as many cells as the
    first, or one more: R writes row numbers without a name. Tables in Markdown lose their outer
    bars.
    """
    text, above = _without_titles(text)
    filled = _filled_lines(text, 2)
    separator = separator_of(text)
    mark = separator.encode()
    if not filled or mark in _outside(filled[0]):
        if separator == "|" and filled[0].startswith(mark):
            barred = (line.strip().removeprefix(mark) for line in LINES.split(text))
            bare = (b"" if RULE.fullmatch(line) else line.removesuffix(mark) for line in barred)
            return b"\n".join(bare), separator, above
        if _has_row_numbers(filled, mark):
            return text.replace(filled[0], mark + filled[0], 1), separator, above
        return text, separator, above
    widths = [len(BLANKS.sub(b" ", _outside(line)).split()) for line in filled]
    if widths[0] < 2 or len(widths) < 2 or widths[1] - widths[0] not in (0, 1):  # noqa: PLR2004
        return text, separator, above
    lines = LINES.split(text)
    tabs = [BLANKS.sub(lambda found: found[1] or b"\t", line.strip()) for line in lines]
    if widths[1] > widths[0]:
        first = next(place for place, line in enumerate(tabs) if line)
        tabs[first] = b"\t" + tabs[first]
    return b"\n".join(tabs), "\t", above


def _has_row_numbers(filled: Sequence[bytes], mark: bytes) -> bool:
    """Return whether the first of two lines lacks the name of the row numbers, as R writes it."""
    if len(filled) < 2:  # noqa: PLR2004 - header and first row
        return False
    first, second = (_outside(line).count(mark) for line in filled)
    return second == first + 1 and filled[1].split(mark)[0].strip(b' "') == b"1"


def _without_titles(text: bytes) -> tuple[bytes, list[int]]:
    """Empty the lines above the header, and return their numbers.

    Lines are above the header if the first has only one cell, or begins like a comment, and the
    header has as many cells as the line below it. A comment above numbers with as many cells, as
    NumPy writes it, is the header.
    """
    first = next(iter(_filled_lines(text, 1)), b"")
    if len(_filled_cells(first)) > 1 and not COMMENT.match(first):
        return text, []
    head = enumerate(LINES.split(text, maxsplit=FIRST)[:FIRST])
    filled = [(place, line) for place, line in head if line.strip(BLANK)]
    for (place, line), (_, below) in pairwise(filled):
        comment = COMMENT.match(line)
        blanks = len(_filled_cells(below)) < 2  # noqa: PLR2004 - no other separator
        if blanks and not COMMENT.match(filled[0][1]):
            return text, []
        bare = line[comment.end() :] if comment else line
        cells = _filled_cells(bare if blanks else line, blanks=blanks)
        rows = _filled_cells(below, blanks=blanks)
        alike = len(cells) == len(rows) > 1
        if comment and alike:
            alike = not any(map(_is_number, cells)) and any(map(_is_number, rows))
        elif blanks:
            alike = not comment
        if not alike:
            continue
        lines = LINES.split(text)
        if comment and comment[1] == b"#" and comment[0].strip() != cells[0].strip():
            lines[place] = bare
        above = [at for at, each in enumerate(lines[:place], 1) if each.strip(BLANK)]
        return b"\n".join([b""] * place + lines[place:]), above
    return text, []


def _filled_cells(line: bytes, *, blanks: bool = False) -> list[bytes]:
    """Return the cells of a line that are not blank, for the separator that gives most of them."""
    outside = _outside(line)
    parts = max((outside.split(mark.encode()) for mark in SEPARATORS), key=len)
    return [cell for cell in (outside.split() if blanks else parts) if cell.strip()]


def _is_number(cell: bytes) -> bool:
    with suppress(ValueError):
        return bool(float(cell.strip().replace(b",", b".")) + 1)
    return False


def _outside(line: bytes) -> bytes:
    return re.sub(rb'"[^"]*"', b"q", line)


def decimal_of(cells: Mapping[str, Mapping[str, int]], *, name: str) -> Decimal:
    """Detect the decimal mark of a file from all its numbers.

    Parameters
    ----------
    cells : Mapping
        Number of occurrences of each distinct cell, keyed by column and cell.
    name : str
        File name to use in error messages.

    Raises
    ------
    UserError
        If the decimal mark is ambiguous: either decimal points and decimal commas are equally
        frequent; or no number is unambiguous, and a comma (or a point in a column with whole
        numbers) could also separate thousands.
    """
    counts: dict[Decimal, int] = {".": 0, ",": 0}
    example: dict[Decimal, tuple[str, str]] = {}
    either: tuple[str, str] | None = None
    for column, values in cells.items():
        # Programs use the same number of decimals within a column: 1.080 next to 540 is probably
        # 1080.
        whole = any(value.strip().isdigit() and value.strip() != "0" for value in values)
        for value, count in values.items():
            text = value.strip()
            for mark, form in CERTAIN.items():
                if form.fullmatch(text):
                    counts[mark] += count
                    example.setdefault(mark, (column, text))
            if either is None and AMBIGUOUS.fullmatch(text) and ("," in text or whole):
                either = (column, text)
    points, commas = counts["."], counts[","]
    if points and points == commas:
        (one, point), (two, comma) = example["."], example[","]
        raise UserError(
            "{name}: decimal points ('{point}' in column {one}) and decimal commas ('{comma}' "
            "in column {two}) are equally frequent; expected only one kind in the whole file",
            name=name,
            point=point,
            one=one,
            comma=comma,
            two=two,
        )
    if points == commas == 0 and either is not None:
        column, text = either
        plain, decimals = re.sub("[.,]", "", text), text.replace(",", ".")
        raise UserError(
            "{name}: column {column}: '{text}' could be {plain} or {decimals}, and no other "
            "number in the file is unambiguous; write numbers without thousands separators, or "
            "specify the decimal mark (--decimal)",
            name=name,
            column=column,
            text=text,
            plain=plain,
            decimals=decimals,
        )
    return "," if commas > points else "."
