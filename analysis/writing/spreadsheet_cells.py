"""Prevent spreadsheets from evaluating free text in tables as a formula.

Text typed by a participant, or a label in a foreign file, can begin with ``=``. Excel and
LibreOffice then evaluate it, and a formula can send cells elsewhere or start programs (CWE-1236).
The journal and the data set's own tables keep every text as it was typed.
"""

from __future__ import annotations

import re

# Characters that a spreadsheet treats as the beginning of a formula, including wide forms; at the
# beginning of a text, or after a possible cell separator on the computer that opens the table (;
# in France).
_FORMULA = re.compile(r'(^|[;,|\t\r\n])(?=[\s"]*[=+\-@＝＋－＠])')
# Numbers in any language's format are left unchanged.
_NUMBER = re.compile(r"[+-]?[0-9]+([.,][0-9]+)?([eE][+-]?[0-9]+)?%?")


def harmless_cell(text: str) -> str:
    """Return text that is safe for spreadsheets: an apostrophe precedes what would be evaluated.

    >>> harmless_cell("=1+1"), harmless_cell("less; =A1"), harmless_cell("-3"), harmless_cell("a-b")
    ("'=1+1", "less;' =A1", '-3', 'a-b')
    """
    return text if _NUMBER.fullmatch(text) else _FORMULA.sub(r"\1'", text)
