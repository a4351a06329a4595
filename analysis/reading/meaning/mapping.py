"""Define the meaning of a table's columns, given by options or ``analysis.toml``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal

import tomlkit
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    StringConstraints,
    ValidationError,
    model_validator,
)

from slipscale.analysis.reading.meaning.layout_rules import rule_of
from slipscale.analysis.reading.meaning.units import column_name, factor
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.faults import UserError
from slipscale.faults.frozen_table import FrozenTable
from slipscale.faults.toml_file import read_toml
from slipscale.faults.validation import complaint, faults_in, sentences
from slipscale.stimuli.quantity import UNNAMED, Quantity

NAME = "analysis.toml"
#: Two consecutive letters, by which codes that are words are recognised.
WORD = re.compile(r"[^\W\d_]{2}")


def _printable(text: str) -> str:
    if not text.isprintable():
        raise ValueError("expected printable characters")
    return text


ColumnName = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, max_length=200)]


class Columns(FrozenTable):
    """Names of the table's columns."""

    participant: ColumnName | None = None
    stimulus: ColumnName | None = None
    response: ColumnName | None = None
    answer: ColumnName | None = None
    yes_count: ColumnName | None = None
    no_count: ColumnName | None = None
    percent: ColumnName | None = None
    n: ColumnName | None = None
    reference: ColumnName | None = None
    first: ColumnName | None = None
    second: ColumnName | None = None
    chosen: ColumnName | None = None
    dissimilarity: ColumnName | None = None
    group: ColumnName | None = None
    factor: ColumnName | None = None
    session: ColumnName | None = None
    run: ColumnName | None = None
    block: ColumnName | None = None
    trial: ColumnName | None = None

    @property
    def named(self) -> dict[str, str]:
        """The names that are given, keyed by field."""
        return {name: str(column) for name, column in self if column}


#: One value or several alternatives.
Alternatives = Annotated[
    tuple[str, ...],
    BeforeValidator(lambda given: (given,) if isinstance(given, str) else given),
    Field(min_length=1),
]


class AnswerWords(FrozenTable):
    """Meaning of the answers.

    Parameters
    ----------
    yes, no, missing : str or tuple of str, optional
        Codes for "yes" (or correct), for "no" (or wrong) and for the absence of an answer; required
        unless the codes are a common pair such as yes/no or 1/0. One code that is left needs no
        statement.
    alternatives : {2, 3}, optional
        Number of alternatives in a forced-choice task, in which "yes" means a correct answer.
    """

    yes: Alternatives | None = None
    no: Alternatives | None = None
    missing: Alternatives | None = None
    alternatives: Literal[2, 3] | None = None

    @property
    def word(self) -> str:
        """Word for "yes" in the report: the code for yes, or "yes" if that code is not a word."""
        (code, *more) = self.yes or ("",)
        return code if not more and code.isprintable() and WORD.search(code) else "yes"


class StimulusWords(FrozenTable):
    """Names and units of the stimulus in the report."""

    name: Annotated[ColumnName, AfterValidator(_printable)] | None = None
    unit: Annotated[
        str,
        StringConstraints(strip_whitespace=True, max_length=40),
        AfterValidator(_printable),
    ] = ""
    in_unit: Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)] | None = None
    judged: Annotated[ColumnName, AfterValidator(_printable)] | None = None

    @property
    def factor(self) -> float:
        """Factor for converting levels from the table's unit to the report's unit."""
        return factor(self.unit, self.in_unit) if self.in_unit else 1.0


class Cells(FrozenTable):
    """Format of the table, and selection of rows."""

    decimal: Literal[".", ","] | None = None
    sheet: ColumnName | None = None
    only: dict[str, Alternatives] = Field(default_factory=dict)


class RowsOf(FrozenTable):
    """Rows of stimuli and rows of answers, which follow each other.

    Parameters
    ----------
    column : str
        Column that contains the kind of row.
    stimulus, answer : str
        Its value in rows with a stimulus, and in rows with an answer.
    """

    column: ColumnName
    stimulus: str
    answer: str


def _pattern(text: str) -> str:
    try:
        groups = re.compile(text).groups
    except re.error as error:
        raise ValueError(f"expected a regular expression ({error})") from None
    if text and groups != 1:
        raise ValueError(
            "expected a pattern with one group in parentheses, such as '(s[0-9]+)_'; write file "
            "names before the option"
        )
    return text


class Shape(FrozenTable):
    """Arrangement of the answers in rows, columns and files.

    Parameters
    ----------
    header : bool
        Whether the first line contains the names of the columns. Without names, the columns are
        called 1, 2, 3 and so on.
    participant_from_name : str, optional
        Regular expression whose group is the participant in each file's name. If it is empty, the
        participant is the part that differs between the names.
    people_in_columns : bool
        Whether the first column contains the levels, and each other column one participant.
    matrix : {"wins", "similarities", "dissimilarities"}, optional
        Content of a square table. In a table of wins, the row's item won against the column's.
    quadruple, triad : tuple of str, optional
        Columns of the stimuli in difference scaling.
    rows_of : RowsOf, optional
        Rows of stimuli and of answers.
    """

    header: bool = True
    participant_from_name: Annotated[str, AfterValidator(_pattern)] | None = None
    people_in_columns: bool = False
    matrix: Literal["wins", "similarities", "dissimilarities"] | None = None
    quadruple: tuple[ColumnName, ColumnName, ColumnName, ColumnName] | None = None
    triad: tuple[ColumnName, ColumnName, ColumnName] | None = None
    rows_of: RowsOf | None = None

    @property
    def compared(self) -> tuple[str, ...]:
        """The columns of stimuli in difference scaling."""
        return self.quadruple or self.triad or ()


class TableMapping(FrozenTable):
    """Meaning of the columns of a table.

    Parameters
    ----------
    columns : Columns
        Names of the columns. The layouts that need them are listed in
        `slipscale.analysis.reading.foreign.layouts.table`. Without names and a shape, the columns
        have the names used by Slipscale.
    stimulus : StimulusWords
        Name and unit of the quantity; by default, the column name without a unit. ``in_unit`` is
        the unit in the report, if it has a different prefix (mPa instead of µPa).
    answers : AnswerWords
        Code for yes, and number of alternatives in a forced-choice task.
    levels : dict
        Stimulus level for each response column of a wide table (one row per participant).
    shape : Shape
        Arrangement of the answers, if they are not in one row per answer.
    table : Cells
        Decimal mark and sheet, which are needed only if they cannot be detected. ``only`` selects
        the rows with given values (column -> value or list of alternative values).
    analysis : AnalysisChoices
        Analysis choices, as in a study file.
    """

    columns: Columns = Columns()
    stimulus: StimulusWords = StimulusWords()
    answers: AnswerWords = AnswerWords()
    levels: dict[ColumnName, Annotated[float, Field(ge=-1e100, le=1e100)]] = Field(
        default_factory=dict
    )
    shape: Shape = Shape()
    table: Cells = Cells()
    analysis: AnalysisChoices = AnalysisChoices()

    @model_validator(mode="after")
    def _one_layout(self) -> TableMapping:
        try:
            _ = self.stimulus.factor
        except UserError as error:
            raise ValueError(str(error)) from None
        if self.of_own:
            if (self.stimulus, self.answers) != (StimulusWords(), AnswerWords()):
                raise ValueError(
                    "expected the columns to which these options belong, such as --stimulus with "
                    "--response or --answer"
                )
            return self
        if len(set(self.levels.values())) < len(self.levels):
            raise ValueError("--levels: expected a different level for each column")
        if fault := rule_of(self.given).fault(self.given):
            raise ValueError(fault)
        used = [*self.columns.named.values(), *self.levels, *self.shape.compared]
        if duplicates := sorted({name for name in used if used.count(name) > 1}):
            raise ValueError(f"column {duplicates[0]} is used twice; expected different columns")
        return self

    @property
    def given(self) -> list[str]:
        """The options that describe the layout; see `analysis.reading.meaning.layout_rules`."""
        own = {"header", "participant_from_name"}
        return [
            *self.columns.named,
            *(name for name in self.shape.model_fields_set - own if getattr(self.shape, name)),
            *(["levels"] if self.levels else []),
            *(name for name, value in self.answers if value is not None),
        ]

    @property
    def of_own(self) -> bool:
        """Whether the table has Slipscale's columns, so that only its format is described."""
        return not (self.columns.named or self.levels or self.shape != Shape())

    @property
    def of_answers(self) -> bool:
        """Whether the table contains answers instead of magnitude estimates."""
        columns = self.columns
        counted = columns.yes_count or columns.no_count or columns.percent or columns.n
        return bool(columns.answer or counted or self.answers.alternatives)

    @property
    def quantity(self) -> Quantity:
        """Quantity of the stimuli, with its name, unit and judged attribute."""
        name = self.stimulus.name or _words(self.columns.stimulus or "stimulus")
        judged = self.stimulus.judged or _words(self.columns.response or UNNAMED)
        unit = self.stimulus.in_unit or self.stimulus.unit
        return Quantity(
            name=name,
            unit=unit,
            column=column_name(name, unit),
            judged=judged,
            yes=self.answers.word,
        )


def _words(column: str) -> str:
    return " ".join(column.replace("_", " ").split()) or column


def parse_mapping(table: Mapping[str, object], source: str) -> TableMapping:
    """Validate a mapping.

    Raises
    ------
    UserError
        If entries are invalid or inconsistent.
    """
    try:
        return TableMapping.model_validate(table)
    except ValidationError as error:
        raise complaint(source, sentences(faults_in(error), lambda _: 0)) from None


def beside(path: Path) -> TableMapping | None:
    """Read ``analysis.toml`` next to a table or in a folder; return None if it does not exist."""
    file = (path if path.is_dir() else path.parent) / NAME
    return read_toml(file, TableMapping) if file.is_file() else None


def write_mapping(mapping: TableMapping, path: Path) -> Path:
    """Write ``analysis.toml`` next to a table or into a folder; return its path.

    Raises
    ------
    UserError
        If a different mapping already exists, or the file cannot be written.
    """
    file = (path if path.is_dir() else path.parent) / NAME
    if file.exists() and beside(path) != mapping:
        raise UserError(
            "{file}: already exists with different content; remove it to save these options",
            file=file,
        )
    try:
        file.write_text(
            tomlkit.dumps(mapping.model_dump(exclude_none=True, exclude_defaults=True)),
            encoding="utf-8",
            newline="\n",
        )
    except OSError as error:
        raise UserError(
            "{file}: cannot be written ({reason}); expected a folder that you may write to; or "
            "omit --map",
            file=file,
            reason=error.strerror,
        ) from error
    return file
