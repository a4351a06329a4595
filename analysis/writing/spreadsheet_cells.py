"""Free text in tables that people open in a spreadsheet: never run as a formula.

What a participant typed, or a label in somebody's file, can begin with ``=``: Excel and LibreOffice
then calculate it, and a formula can send cells elsewhere or start programs (CWE-1236). The journal
and the data set's own tables keep every text as it was typed.
"""

from __future__ import annotations

import re

# What a spreadsheet takes for the beginning of a formula, wide forms included; at the beginning of
# a text or after what may be the separator of cells where the table is opened (; in France).
_FORMULA = re.compile(r'(^|[;,|\t\r\n])(?=[\s"]*[=+\-@＝＋－＠])')
# A number is one in every language of a spreadsheet, and stays one.
_NUMBER = re.compile(r"[+-]?[0-9]+([.,][0-9]+)?([eE][+-]?[0-9]+)?%?")


def harmless_cell(text: str) -> str:
    """Return a text as a spreadsheet shows it: an apostrophe before what it would calculate.

    >>> harmless_cell("=1+1"), harmless_cell("less; =A1"), harmless_cell("-3"), harmless_cell("a-b")
    ("'=1+1", "less;' =A1", '-3', 'a-b')
    """
    return text if _NUMBER.fullmatch(text) else _FORMULA.sub(r"\1'", text)
