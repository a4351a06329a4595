"""List the programs whose files can be read.

The first program that recognises a file reads it. All other files are read as ordinary text
tables. To support another program, write a module and add a line to `PROGRAMS`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from slipscale.analysis.reading.programs import e_prime, jspsych, matlab, qualtrics
from slipscale.analysis.reading.programs.records import head_of
from slipscale.analysis.reading.programs.spreadsheets import read_excel, read_spss
from slipscale.faults import UserError

EXCEL = (".xlsx", ".xlsm", ".xls", ".xlsb")
SPSS = (".sav", ".zsav")


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """Options for reading a file.

    Parameters
    ----------
    words : sequence of str
        Columns with text. In SPSS files, the values in these columns are replaced by their labels.
    sheet : str, optional
        Sheet of a workbook, or variable in a MATLAB file.
    """

    words: Sequence[str]
    sheet: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Program:
    """A program that writes files which Slipscale can read.

    Parameters
    ----------
    name : str
    recognises : callable
        Function that returns whether the program wrote the file, whose beginning is the first
        argument (see `head_of`).
    read : callable
        Function that returns the cells as text or, if the program stores numbers, as numbers, with
        line numbers in the column ``line``.
    """

    name: str
    recognises: Callable[[str, Path], bool]
    read: Callable[[bytes, Path, Wanted], pd.DataFrame]


def _with_suffix(*suffixes: str) -> Callable[[str, Path], bool]:
    return lambda _, path: path.suffix.lower() in suffixes


def _refuse_jasp(_content: bytes, path: Path, _wanted: Wanted) -> pd.DataFrame:
    raise UserError(
        "{path}: JASP files are not supported; export the data from JASP as CSV", path=path
    )


PROGRAMS = (
    Program(
        name="Excel",
        recognises=_with_suffix(*EXCEL),
        read=lambda content, path, wanted: read_excel(content, path, wanted.sheet),
    ),
    Program(
        name="SPSS",
        recognises=_with_suffix(*SPSS),
        read=lambda content, path, wanted: read_spss(content, path, wanted.words),
    ),
    Program(name="JASP", recognises=_with_suffix(".jasp"), read=_refuse_jasp),
    Program(
        name="MATLAB",
        recognises=matlab.recognises,
        read=lambda content, path, wanted: matlab.read(content, path, wanted.sheet),
    ),
    Program(
        name="jsPsych",
        recognises=jspsych.recognises,
        read=lambda content, path, _: jspsych.read(content, path),
    ),
    Program(
        name="Qualtrics",
        recognises=qualtrics.recognises,
        read=lambda content, path, _: qualtrics.read(content, path),
    ),
    Program(
        name="E-Prime",
        recognises=e_prime.recognises,
        read=lambda content, path, _: e_prime.read(content, path),
    ),
)


def program_of(content: bytes, path: Path) -> Program | None:
    """Return the program that wrote a file, or None for an ordinary text table."""
    head = head_of(content, path)
    return next((each for each in PROGRAMS if each.recognises(head, path)), None)
