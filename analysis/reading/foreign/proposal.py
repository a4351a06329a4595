"""Describe the columns of a table, and propose the options that state what they mean.

What the table does not reveal is asked for: which of several columns contains the levels, and which
contains the answers.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from slipscale.analysis.reading.cells import cell, listed
from slipscale.analysis.reading.cleaning import as_numbers
from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.foreign.files import in_folder
from slipscale.analysis.reading.foreign.presets import columns_of, preset_of
from slipscale.analysis.reading.meaning.mapping import beside
from slipscale.analysis.reading.table_by_hand import read_table
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError
from slipscale.faults.folders import visible

#: Columns of a table that need no options.
OWN = (PARTICIPANT, "amplitude_um_pp", "estimate")
#: Largest number of values that are listed, and of levels.
LISTED, MOST_LEVELS = 8, 30
#: Smallest number of levels.
FEWEST_LEVELS = 3
#: Names of columns that count trials or contain times.
NO_LEVELS = re.compile(
    r"(?i)this(rep|trial)?n$|(^|[._ ])(rt|time|index|trial|block|run|session|age)|time$|_nr$"
)
#: Responses with so few different values are codes.
CODES = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """Description of a column.

    Parameters
    ----------
    name : str
    values : tuple of str
        Its most frequent values, at most `LISTED`; numbers in ascending order.
    distinct, missing : int
        Number of different values, and of blank cells.
    range : tuple of float or None
        Smallest and largest number; None if the values are not numbers.
    """

    name: str
    values: tuple[str, ...]
    distinct: int
    missing: int
    range: tuple[float, float] | None

    @property
    def like_levels(self) -> bool:
        """Whether the column could contain the levels."""
        few = self.range is not None and FEWEST_LEVELS <= self.distinct <= MOST_LEVELS
        return few and not NO_LEVELS.search(self.name)

    def __str__(self) -> str:
        """Return the description in one line."""
        kind = "text" if self.range is None else f"{self.range[0]:g} to {self.range[1]:g}"
        more = ", ..." if self.distinct > len(self.values) else ""
        blank = f"; {self.missing} missing" if self.missing else ""
        count = "1 value" if self.distinct == 1 else f"{self.distinct} values"
        return f"{cell(self.name)}: {kind}, {count} ({', '.join(self.values)}{more}){blank}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Proposal:
    """Proposed options for a table.

    Parameters
    ----------
    tables : tuple of Path
        The tables, of which the first is described.
    program : str
        Program that wrote the table; empty if it is unknown.
    rows : int
    columns : tuple of Column
    command : str
        Proposed command, with names in capital letters for what is unknown.
    questions : tuple of str
        What is unknown, with the candidates.
    """

    tables: tuple[Path, ...]
    program: str
    rows: int
    columns: tuple[Column, ...]
    command: str
    questions: tuple[str, ...]

    def __str__(self) -> str:
        """Return the description and the questions, one per line."""
        many = f", the first of {len(self.tables)} tables" if len(self.tables) > 1 else ""
        by = f", {self.program}" if self.program else ""
        head = f"{self.tables[0].name}{many}: {self.rows} rows{by}"
        return "\n".join([head, *(f"  {column}" for column in self.columns), *self.questions])

    @property
    def refusal(self) -> UserError:
        """The error that asks for options."""
        return UserError(
            "{path}: no columns {own}, and no options state what the columns mean; expected "
            "options, for example: {command}",
            path=self.tables[0],
            own=", ".join(OWN),
            command=self.command,
        )


def proposal_for(paths: Sequence[Path]) -> Proposal | None:
    """Describe the first of several tables; return None if the data need no options."""
    tables = [path for path in paths if path.is_file()]
    for path in paths:
        of_bids = path.is_dir() and any(visible(path, "sub-*/**/*.tsv"))
        if path.is_dir() and not of_bids and any(visible(path, "**/*.*")):
            tables += in_folder(path, Problems())
    if not tables or beside(paths[0]) is not None:
        return None
    frame = _cells(tables[0])
    return None if set(OWN) <= set(frame.columns) else propose(frame, paths, tables)


def _cells(path: Path) -> pd.DataFrame:
    """Return all cells of a table; a first line of numbers is no header."""
    read = partial(
        read_table,
        path,
        required=(),
        numbers=(),
        words=(),
        identifier=None,
        problems=Problems(),
        everything=True,
    )
    frame, _ = read()
    names = [str(name) for name in frame.columns if name not in ("file", "line")]
    if as_numbers(pd.Series(names, dtype="str"))[1].notna().all():
        frame, _ = read(header=False)
    return frame.drop(columns=["file", "line"])


def describe(frame: pd.DataFrame) -> tuple[Column, ...]:
    """Describe the columns that contain any value."""
    return tuple(_column(str(name), frame[name]) for name in frame if frame[name].notna().any())


def _column(name: str, cells: pd.Series[Any]) -> Column:
    text, numbers = as_numbers(cells)
    text = text.dropna()
    whole = bool(len(text)) and bool(numbers[text.index].notna().all())
    counts = (numbers if whole else text).value_counts()
    shown = sorted(counts.index[:LISTED]) if whole else counts.index[:LISTED]
    return Column(
        name=name,
        values=tuple(f"{value:g}" if whole else cell(value) for value in shown),
        distinct=len(counts),
        missing=len(cells) - len(text),
        range=(float(numbers.min()), float(numbers.max())) if whole else None,
    )


def propose(frame: pd.DataFrame, paths: Sequence[Path], tables: Sequence[Path]) -> Proposal:
    """Propose options for a table, or for several with the same columns."""
    columns = describe(frame)
    names = [column.name for column in columns]
    numbered = names == [str(place) for place in range(1, len(names) + 1)]
    preset = preset_of(names)
    likely = columns_of(preset, names)
    options = ["--no-header"] if numbered else []
    questions: list[str] = []
    if people := likely.pop("participant", []):
        options += ["--participant", people[0]]
    elif len(tables) > 1:
        options += ["--participant-from-name"]
    if square := _square(frame):
        options += ["--matrix", square]
    elif preset.fixed:
        options += preset.fixed
    else:
        used = {*people, *(name for found in likely.values() for name in found)}
        levels = [column for column in columns if column.like_levels and column.name not in used]
        options += ["--stimulus", _one("LEVEL", levels, "the levels (--stimulus)", questions)]
        options += _answers(likely, [c for c in columns if c.name in used], questions)
    files = [path.name if path.parent == Path() else str(path) for path in paths]
    return Proposal(
        tables=tuple(tables),
        program=preset.name,
        rows=len(frame),
        columns=columns,
        command=shlex.join(["slipscale", "analyse", *files, *options, "--map"]),
        questions=tuple(questions),
    )


def _square(frame: pd.DataFrame) -> str:
    """Return the content of a square table of items, or "" for other tables."""
    first, *items = frame.columns
    labels = frame[first].fillna("").astype(str)
    if not items or sorted(labels) != sorted(items):
        return ""
    cells = frame.set_index(labels)[items].loc[items]
    values = cells.apply(lambda column: as_numbers(column)[1]).to_numpy(float)
    if not np.array_equal(values, values.T, equal_nan=True):
        return "wins"
    return (
        "similarities" if np.nanmin(values.diagonal()) == np.nanmax(values) else "dissimilarities"
    )


def _answers(
    likely: dict[str, list[str]], columns: Sequence[Column], questions: list[str]
) -> list[str]:
    """Return the options for counts, for answers or for estimates, in this order."""
    if likely.get("yes_count") and likely.get("n"):
        return ["--yes-count", likely["yes_count"][0], "--n", likely["n"][0]]
    for name in ("answer", "response"):
        found = [column for column in columns if column.name in likely.get(name, [])]
        if found:
            coded = name == "answer" or found[0].range is None or found[0].distinct <= CODES
            option = "--answer" if coded else "--response"
            return [option, _one("COLUMN", found, f"the answers ({option})", questions)]
    questions.append(
        "Which column contains the answers: estimates (--response), yes or no (--answer), or "
        "counts (--yes-count and --n)? In a forced choice, add --alternatives 2 or 3."
    )
    return ["--response", "RESPONSE"]


def _one(unknown: str, found: Sequence[Column], what: str, questions: list[str]) -> str:
    """Return the only candidate; for several or none, ask."""
    if len(found) == 1:
        return found[0].name
    candidates = listed(f"{column.name} ({', '.join(column.values)})" for column in found)
    questions.append(f"Which column contains {what}? {candidates or 'No column looks like it'}.")
    return found[0].name if found else unknown
