"""List the programs whose files can be read.

The first program that recognises a file reads it. All other files are read as ordinary text
tables. To support another program, write a module and add a line to `PROGRAMS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from slipscale.analysis.reading.programs import e_prime, jspsych, matlab, qualtrics, unsupported
from slipscale.analysis.reading.programs.records import head_of
from slipscale.analysis.reading.programs.spreadsheets import LABELLED, read_excel, read_labelled
from slipscale.analysis.reading.programs.wanted import Wanted

EXCEL = (".xlsx", ".xlsm", ".xls", ".xlsb")


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


def _refuse(_content: bytes, path: Path, _wanted: Wanted) -> pd.DataFrame:
    raise unsupported.refuse(path)


PROGRAMS = (
    Program(
        name="Excel",
        recognises=_with_suffix(*EXCEL),
        read=read_excel,
    ),
    Program(
        name="SPSS or Stata",
        recognises=_with_suffix(*LABELLED),
        read=read_labelled,
    ),
    Program(name="unsupported", recognises=unsupported.recognises, read=_refuse),
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
