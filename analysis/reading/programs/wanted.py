"""Define what is read from the file of a program."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """Options for reading a file.

    Parameters
    ----------
    words : sequence of str
        Columns with text. In files of SPSS and Stata, their values are replaced by their labels.
    sheet : str, optional
        Sheet of a workbook, or variable in a MATLAB file.
    columns : collection of str, optional
        All columns that are analysed; by default, any.
    """

    words: Sequence[str]
    sheet: str | None
    columns: Collection[str] | None = None
