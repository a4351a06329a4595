"""Prevent spreadsheets from evaluating text in tables as formulas.

Text that a participant typed, or a label in a file from another program, can begin with ``=``.
Excel and LibreOffice evaluate such text, and a formula can send data elsewhere or start programs
(CWE-1236). Every table is written with `harmless_cell`; journals contain the text itself.
"""

from __future__ import annotations

import re

# Characters that begin a formula (including their full-width forms), at the start of the text or
# after a character that some locales use as the cell separator (; in France).
_FORMULA = re.compile(r'(^|[;,|\t\r\n])(?=[\s"]*[=+\-@＝＋－＠])')
# Numbers in the format of any language, which are left unchanged.
_NUMBER = re.compile(r"[+-]?[0-9]+([.,][0-9]+)?([eE][+-]?[0-9]+)?%?")


def harmless_cell(text: str) -> str:
    """Return text with an apostrophe before anything that a spreadsheet would evaluate.

    >>> harmless_cell("=1+1"), harmless_cell("less; =A1"), harmless_cell("-3"), harmless_cell("a-b")
    ("'=1+1", "less;' =A1", '-3', 'a-b')
    """
    return text if _NUMBER.fullmatch(text) else _FORMULA.sub(r"\1'", text)
