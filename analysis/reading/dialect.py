"""How a table by hand writes its cells: encoding, separator, decimal mark, marks in thousands.

Decided once for a whole file, from all its numbers, so that one bad cell changes nothing for the
others. A number that can be read in two ways, with nothing in the file that decides, is refused.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Literal

from slipscale.faults import UserError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

Decimal = Literal[".", ","]
#: Separators of a table by hand; among equals the first.
SEPARATORS = ("\t", ";", ",")
BOMS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}
#: What Excel on Windows writes in western Europe where nobody asks for UTF-8.
FALLBACK = "cp1252"

_TAIL = r"(?:[eE][+-]?\d+)?"
#: Blanks and the Swiss apostrophe may part thousands beside either decimal mark.
_GAPS = r"[ '\u2019\u00a0\u202f]"


def _certain(mark: str, other: str) -> re.Pattern[str]:
    """Return the form of numbers in which ``mark`` can only be the decimal mark."""
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
#: A number whose point may part thousands, in a file's text.
THOUSANDS_POINT = re.compile(rb"(?<![\d.])[1-9]\d{0,2}\.\d{3}(?![\d.])")


def in_points(cell: str, decimal: Decimal) -> str:
    """Return a cell with a decimal point and bare thousands; one that is no number as it was.

    The mark that is not the decimal one, blanks and apostrophes may part thousands.

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
    """Return a text file's content as UTF-8, and what its encoding was.

    UTF-8, UTF-16 where a byte-order mark says so, else Windows-1252.

    Raises
    ------
    UserError
        The content is none of these.
    """
    encoding = next((name for mark, name in BOMS.items() if content.startswith(mark)), "utf-8")
    try:
        return content.decode(encoding).encode("utf-8"), encoding
    except UnicodeError as error:
        start = error.start if isinstance(error, UnicodeDecodeError) else 0
    # A null byte or a byte-order mark is not from Windows-1252.
    if encoding == "utf-8" and b"\x00" not in content:
        try:
            return content.decode(FALLBACK).encode("utf-8"), FALLBACK
        except UnicodeDecodeError:
            pass
    line = content.count(b"\n", 0, start) + 1
    expected = "UTF-16" if encoding == "utf-16" else "UTF-8"
    raise UserError(
        f"{path}: line {line} is not {expected} text; expected a text table "
        "(from Excel: save as 'CSV UTF-8')"
    )


def separator_of(header: bytes) -> str:
    """Return the separator of a header line: what parts its cells, not what is inside quotes."""
    outside = re.sub(rb'"[^"]*"', b"", header)
    return next((mark for mark in SEPARATORS if mark.encode() in outside), ",")


def decimal_of(cells: Mapping[str, Mapping[str, int]], *, name: str) -> Decimal:
    """Return the decimal mark of a file from all its numbers.

    Parameters
    ----------
    cells : Mapping
        Column -> its distinct cells -> how often each is there.
    name : str
        The file's, for messages.

    Raises
    ------
    UserError
        A comma may part thousands or be the decimal mark, and nothing decides; so may a point, in a
        column that holds whole numbers too; or both marks are there as often.
    """
    counts: dict[Decimal, int] = {".": 0, ",": 0}
    example: dict[Decimal, tuple[str, str]] = {}
    either: tuple[str, str] | None = None
    for column, values in cells.items():
        # Programs write all decimals of a column or none: 1.080 beside 540 is probably 1080.
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
            f"{name}: decimal points ('{point}' in column {one}) and decimal commas ('{comma}' in "
            f"column {two}) are there as often; expected one of them in the whole file"
        )
    if points == commas == 0 and either is not None:
        column, text = either
        plain, decimals = re.sub("[.,]", "", text), text.replace(",", ".")
        raise UserError(
            f"{name}: column {column}: '{text}' can be {plain} or {decimals}, and no other number "
            "of the file decides; write numbers without marks between thousands, or state the "
            "decimal mark (--decimal)"
        )
    return "," if commas > points else "."
