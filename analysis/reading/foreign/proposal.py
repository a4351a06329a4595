"""Describe the columns of a table, and propose the options that state what they mean.

What the table does not reveal is asked for: which of several columns contains the levels, which
contains the answers, and which codes mean yes.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pandas as pd

from slipscale.analysis.reading.answer_codes import are_usual
from slipscale.analysis.reading.cells import listed
from slipscale.analysis.reading.cleaning import as_numbers
from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.foreign.described_columns import (
    NO_LEVELS,
    Column,
    describe,
    levels_in,
)
from slipscale.analysis.reading.foreign.files import BIDS_TABLE, in_folder
from slipscale.analysis.reading.foreign.presets import columns_of, preset_of
from slipscale.analysis.reading.foreign.recognition import Given, layout_of
from slipscale.analysis.reading.meaning.mapping import beside
from slipscale.analysis.reading.programs.wanted import SeveralTables
from slipscale.analysis.reading.table_by_hand import Request, read_table
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError
from slipscale.faults.folders import visible

#: Columns of a table that need no options.
OWN = (PARTICIPANT, "amplitude_um_pp", "estimate")
#: Largest number of conditions of a proposed factor, smallest proportion of their combinations with
#: levels that occur, and names of columns that describe trials or answers.
MOST_CONDITIONS, CROSSED = 6, 0.75
NO_CONDITIONS = re.compile(r"(?i)key|resp|answer|correct|choice|side|order|block|session|run")
#: Responses with so few different values are codes.
CODES = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """What a table does not reveal.

    Parameters
    ----------
    option : str
        The option in question, as a keyword; "results" for the kind of answers.
    candidates : tuple of Column
        Columns that the option could name; for codes, the column that contains them.
    """

    option: str
    candidates: tuple[Column, ...]

    def __str__(self) -> str:
        """Return the question in one sentence, with the candidates and their values."""
        text = QUESTIONS[self.option]
        if self.option in (RESULTS, SHEET):
            return text
        shown = listed(f"{column.name} ({', '.join(column.values)})" for column in self.candidates)
        return f"{text} {shown or 'No column looks like it'}."


RESULTS, SHEET = "results", "sheet"
QUESTIONS = {
    SHEET: "Which sheet contains the data (--sheet)? The first one is described.",
    "stimulus": "Which column contains the levels (--stimulus)?",
    "answer": "Which column contains the answers (--answer)?",
    "response": "Which column contains the answers (--response)?",
    "yes": "Which codes mean yes or correct (--yes)?",
    RESULTS: (
        "Which column contains the answers: estimates (--response), yes or no (--answer), or "
        "counts (--yes-count and --n)? In a forced choice, add --alternatives 2 or 3."
    ),
}
#: Options for counts of answers.
COUNTED = (("yes_count", "n"), ("yes_count", "no_count"), ("percent", "n"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Proposal:
    """Proposed options for a table.

    Parameters
    ----------
    paths : tuple of Path
        The data, as given.
    tables : tuple of Path
        The tables, of which the first is described.
    program : str
        Program that wrote the table; empty if it is unknown.
    frame : DataFrame
        The cells of the first table.
    columns : tuple of Column
    sheets : tuple of str
        Sheets of the workbook, if there are several; one of them is described.
    given : Mapping
        Proposed options, as keywords, with names in capital letters for what is unknown.
    questions : tuple of Question
        What is unknown.
    """

    paths: tuple[Path, ...]
    tables: tuple[Path, ...]
    program: str
    frame: pd.DataFrame
    columns: tuple[Column, ...]
    sheets: tuple[str, ...]
    given: Mapping[str, object]
    questions: tuple[Question, ...]

    @property
    def command(self) -> str:
        """The proposed command."""
        files = [path.name if path.parent == Path() else str(path) for path in self.paths]
        return shlex.join(["slipscale", "analyse", *files, *as_options(self.given), "--map"])

    def __str__(self) -> str:
        """Return the description and the questions, one per line."""
        many = f", the first of {len(self.tables)} tables" if len(self.tables) > 1 else ""
        by = f", {self.program}" if self.program else ""
        by += f", sheet {self.given[SHEET]} of {listed(self.sheets)}" if self.sheets else ""
        head = f"{self.tables[0].name}{many}: {len(self.frame)} rows{by}"
        return "\n".join(
            [head, *(f"  {column}" for column in self.columns), *map(str, self.questions)]
        )

    @property
    def refusal(self) -> Unstated:
        """The error that asks for options."""
        return Unstated(self)


class Unstated(UserError):
    """Raised if no options state what the columns of a table mean."""

    def __init__(self, proposal: Proposal) -> None:
        super().__init__(
            "{path}: no columns {own}, and no options state what the columns mean; expected "
            "options, for example: {command}",
            path=proposal.tables[0],
            own=", ".join(OWN),
            command=proposal.command,
        )
        self.proposal = proposal


def as_options(given: Mapping[str, object]) -> list[str]:
    """Return keywords as options of the command line."""
    words: list[str] = []
    for name, value in given.items():
        words.append(f"--{name.replace('_', '-')}")
        if isinstance(value, list | tuple):
            words += map(str, value)
        elif value is not True and value != "":
            words.append(str(value))
    return words


def proposal_for(paths: Sequence[Path], sheet: str | None = None) -> Proposal | None:
    """Describe the first of several tables; return None if the data need no options."""
    found = None if beside(paths[0]) is not None else described(paths, sheet)
    return None if found is None or set(OWN) <= set(found.frame.columns) else found


def described(paths: Sequence[Path], sheet: str | None = None) -> Proposal | None:
    """Describe the first of several tables; return None if there is no table.

    Of several sheets, the stated or the first one is described.
    """
    tables = [path for path in paths if path.is_file()]
    for path in paths:
        if not path.is_dir():
            continue
        of_bids = list(visible(path, "sub-*/**/*.tsv"))
        if of_bids:
            tables += [each for each in of_bids if BIDS_TABLE.fullmatch(each.name)]
        elif any(visible(path, "**/*.*")):
            tables += in_folder(path, Problems())
    if not tables:
        return None
    sheets: tuple[str, ...] = ()
    try:
        frame = _cells(tables[0], None)
    except SeveralTables as several:
        sheets = several.names
        frame = _cells(tables[0], sheet or sheets[0])
    found = propose(frame, paths, tables)
    if not sheets:
        return found
    asked = () if sheet else (Question(option=SHEET, candidates=()),)
    given = {SHEET: sheet or sheets[0], **found.given}
    return replace(found, sheets=sheets, given=given, questions=(*asked, *found.questions))


def _cells(path: Path, sheet: str | None) -> pd.DataFrame:
    """Return all cells of a table; a first line like the other lines is no header."""

    def read(*, header: bool) -> pd.DataFrame:
        request = Request(everything=True, header=header, sheet=sheet)
        return read_table(path, request, Problems())[0].drop(columns=["file", "line"])

    try:
        frame = read(header=True)
    except UserError as error:
        # Values occur twice in a line, names do not.
        with suppress(UserError):
            return read(header=False)
        raise error from None
    if len(frame) and all(_like_a_cell(str(name), frame[name]) for name in frame):
        return read(header=False)
    return frame


def _like_a_cell(name: str, cells: pd.Series[Any]) -> bool:
    """Return whether the name of a column is a number above numbers, or one of the words below."""
    text, numbers = as_numbers(cells)
    if numbers.notna().any():
        return bool(as_numbers(pd.Series([name], dtype="str"))[1].notna().all())
    return bool((text.str.strip() == name.strip()).any())


def propose(frame: pd.DataFrame, paths: Sequence[Path], tables: Sequence[Path]) -> Proposal:
    """Propose options for a table, or for several with the same columns."""
    columns = describe(frame)
    names = [column.name for column in columns]
    preset = preset_of(names)
    likely = columns_of(preset, names)
    numbered = names == [str(place) for place in range(1, len(names) + 1)]
    given: Given = {"no_header": True} if numbered else {}
    questions: list[Question] = []
    people = likely.pop("participant", [])
    layout = dict(preset.fixed)
    if not layout and preset.name in KNOWN_COLUMNS:
        layout = layout_of(frame.drop(columns=people[:1]))
    if people:
        given["participant"] = people[0]
    elif len(tables) > 1 and not BIDS_TABLE.fullmatch(tables[0].name):
        given["participant_from_name"] = ""
    if layout:
        given |= layout
    else:
        used = {*people[:1], *(name for found in likely.values() for name in found)}
        free = [column for column in columns if column.name not in used]
        levels, certain = levels_in(frame, people, free)
        given["stimulus"] = _one("stimulus", levels, questions, certain=certain)
        used |= {str(given["stimulus"])}
        others = [column for column in columns if column.name not in used]
        named = {name: [c for c in found if c not in people] for name, found in likely.items()}
        given |= _answers(named, columns, others, questions)
        asked = {column.name for question in questions for column in question.candidates}
        free = [column for column in columns if column.name not in {*given.values(), *asked}]
        if people and levels:
            given |= _factor(frame, people[0], str(given["stimulus"]), free)
    coded = coded_answer(columns, given)
    if coded is not None:
        given["yes"] = ["CODE"]
        questions.append(Question(option="yes", candidates=(coded,)))
    return Proposal(
        paths=tuple(paths),
        tables=tuple(tables),
        program=preset.name,
        frame=frame,
        columns=columns,
        sheets=(),
        given=given,
        questions=tuple(questions),
    )


#: Presets whose columns may have any layout.
KNOWN_COLUMNS = ("", "BIDS events")


def _answers(
    likely: Mapping[str, Sequence[str]],
    columns: Sequence[Column],
    others: Sequence[Column],
    questions: list[Question],
) -> Given:
    """Return the options for counts, for answers or for estimates, in this order.

    If no column is named like answers, the only other column is proposed.
    """
    for pair in COUNTED:
        if all(likely.get(name) for name in pair):
            return {name: likely[name][0] for name in pair}
    alone = [column for column in others if not NO_LEVELS.search(column.name)]
    for name in ("answer", "response"):
        found = [column for column in columns if column.name in likely.get(name, [])]
        if not found and name == "response" and len(alone) == 1 and alone[0].distinct > 1:
            found = alone
        if found:
            coded = name == "answer" or found[0].range is None or found[0].distinct <= CODES
            option = "answer" if coded else "response"
            return {option: _one(option, found, questions)}
    usual = [column for column in alone if column.distinct > 1 and are_usual(column.values)]
    if len(usual) == 1:
        return {"answer": usual[0].name}
    questions.append(Question(option=RESULTS, candidates=tuple(others)))
    return {"response": "RESPONSE"}


def _factor(frame: pd.DataFrame, who: str, stimulus: str, free: Sequence[Column]) -> Given:
    """Return the only column of words that is crossed with the participants and the levels."""
    found = [
        column.name
        for column in free
        if column.range is None and 1 < column.distinct <= MOST_CONDITIONS
        if not NO_CONDITIONS.search(column.name)
        if all(
            len(frame[[column.name, other]].dropna().drop_duplicates())
            >= least * column.distinct * frame[other].nunique()
            for other, least in ((who, 1), (stimulus, CROSSED))
        )
    ]
    return {"factor": found[0]} if len(found) == 1 else {}


def coded_answer(columns: Sequence[Column], given: Mapping[str, object]) -> Column | None:
    """Return the column of answers if the meaning of its codes has to be stated."""
    found = next((column for column in columns if column.name == given.get("answer")), None)
    return None if found is None or are_usual(found.values) else found


def _one(
    option: str, found: Sequence[Column], questions: list[Question], *, certain: bool = True
) -> str:
    """Return the only candidate; if it is not certain, or for several or none, ask."""
    if len(found) != 1 or not certain:
        questions.append(Question(option=option, candidates=tuple(found)))
    if option == "stimulus" and not certain:
        return "LEVEL"
    return found[0].name if found else "LEVEL" if option == "stimulus" else "COLUMN"
