"""Detect a table's format: encoding, separator, decimal mark and thousands separators.

The format is detected once per file from all numbers, so that an invalid cell does not affect the
interpretation of other cells. Ambiguous numbers are rejected unless other numbers in the file
resolve the ambiguity.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import numpy as np

from slipscale.faults import UserError

Decimal = Literal[".", ","]
#: Possible separators, in order of preference.
SEPARATORS = ("\t", ";", ",")
#: Ends of lines, and the number of lines in which two with cells are searched.
LINES, FIRST = re.compile(rb"\r\n|\n|\r"), 20
#: A quoted cell, or blanks between cells.
BLANKS = re.compile(rb'("[^"]*")|[ ]+')
BOMS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}
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

    The content is decoded as UTF-8, as UTF-16 if it has a byte-order mark, or otherwise as
    Windows-1252.

    Raises
    ------
    UserError
        If the content is in none of these encodings.
    """
    if content.isascii() and b"sep=" not in content[:LONGEST_HINT].lower():
        return content, "utf-8"  # most tables are; nothing is copied
    encoding = next((name for mark, name in BOMS.items() if content.startswith(mark)), "utf-8")
    try:
        return _without_hint(content.decode(encoding)).encode("utf-8"), encoding
    except UnicodeError as error:
        start = error.start if isinstance(error, UnicodeDecodeError) else 0
    # Null bytes and byte-order marks do not occur in Windows-1252.
    if encoding == "utf-8" and b"\x00" not in content:
        try:
            return _without_hint(content.decode(FALLBACK)).encode("utf-8"), FALLBACK
        except UnicodeDecodeError:
            pass
    line = content.count(b"\n", 0, start) + 1
    expected = "UTF-16" if encoding == "utf-16" else "UTF-8"
    raise UserError(
        "{path}: line {line} is not {expected} text; expected a text table (from Excel: save as"
        " 'CSV UTF-8')",
        path=path,
        line=line,
        expected=expected,
    )


def _without_hint(text: str) -> str:
    """Empty a first line such as ``sep=;``, which tells Excel the separator.

    The line stays, so that line numbers in messages are those of the file.
    """
    return HINT.sub("", text, count=1)


def separator_of(text: bytes) -> str:
    """Detect the separator in the first line, ignoring characters inside quotes."""
    header = LINES.split(text.lstrip(b"\r\n"), maxsplit=1)[0]
    return next((mark for mark in SEPARATORS if mark.encode() in _outside(header)), ",")


def separated(text: bytes) -> tuple[bytes, str]:
    """Return a table's text and its separator; runs of blanks become tabs.

    A table is separated by blanks if its first line has no other separator, and its second line has
    as many cells as the first, or one more: R writes row numbers without a name.
    """
    # Only the first lines are split at first, because most tables are not separated by blanks.
    filled = [line for line in LINES.split(text.lstrip(), maxsplit=FIRST) if line.strip()][:2]
    if not filled or any(mark.encode() in _outside(filled[0]) for mark in SEPARATORS):
        return text, separator_of(text)
    widths = [len(BLANKS.sub(b" ", _outside(line)).split()) for line in filled]
    if widths[0] < 2 or len(widths) < 2 or widths[1] - widths[0] not in (0, 1):  # noqa: PLR2004
        return text, separator_of(text)
    lines = LINES.split(text)
    tabs = [BLANKS.sub(lambda found: found[1] or b"\t", line.strip()) for line in lines]
    if widths[1] > widths[0]:
        first = next(place for place, line in enumerate(tabs) if line)
        tabs[first] = b"\t" + tabs[first]
    return b"\n".join(tabs), "\t"


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
