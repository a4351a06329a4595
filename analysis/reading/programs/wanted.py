"""Define what is read from the file of a program."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from slipscale.faults import UserError


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


class SeveralTables(UserError):
    """Raised if a file contains several tables and none is selected; ``names`` are their names."""

    def __init__(self, template: str, names: Sequence[str], **values: object) -> None:
        super().__init__(template, **values)
        self.names = tuple(names)
