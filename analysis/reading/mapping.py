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

from slipscale.analysis.reading.units import factor
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.faults import UserError
from slipscale.faults.frozen_table import FrozenTable
from slipscale.faults.toml_file import read_toml
from slipscale.faults.validation import complaint, faults_in, sentences
from slipscale.stimuli.quantity import UNNAMED, Quantity

NAME = "analysis.toml"
#: Two consecutive letters, by which codes that are words are recognised.
WORD = re.compile(r"[^\W\d_]{2}")
#: Message for a trial number in a table with several responses per row.
TRIAL_OF_SEVERAL = (
    "a trial number requires one response per row; expected no column for the trial in a wide "
    "table or a table of counts"
)


def _printable(text: str) -> str:
    if not text.isprintable():
        raise ValueError("expected printable characters")
    return text


ColumnName = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, max_length=200)]


class Columns(FrozenTable):
    """Names of the table's columns."""

    participant: ColumnName
    stimulus: ColumnName | None = None
    response: ColumnName | None = None
    answer: ColumnName | None = None
    yes_count: ColumnName | None = None
    n: ColumnName | None = None
    reference: ColumnName | None = None
    first: ColumnName | None = None
    second: ColumnName | None = None
    dissimilarity: ColumnName | None = None
    group: ColumnName | None = None
    factor: ColumnName | None = None
    session: ColumnName | None = None
    run: ColumnName | None = None
    block: ColumnName | None = None
    trial: ColumnName | None = None


#: Columns of a table with the names that Slipscale uses, which need no mapping.
OWN = Columns.model_construct(participant="")


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


class TableMapping(FrozenTable):
    """Meaning of the columns of a table.

    Parameters
    ----------
    columns : Columns
        Names of the columns with the participant, the stimulus, and the magnitude estimate
        (``response``) or yes/no answer (``answer``). A table of yes/no answers may also have a
        column for the previous stimulus (``reference``, default: 0). A table of counts contains the
        number of yes answers (``yes_count``) and the total number of answers (``n``). Ratings of
        pairs have two items (``first``, ``second``) and their ``dissimilarity``. A ``factor`` is a
        condition that varies within participants. By default, the columns have the names used by
        Slipscale.
    stimulus : StimulusWords
        Name and unit of the quantity; by default, the column name without a unit. ``in_unit`` is
        the unit in the report, if it has a different prefix (mPa instead of µPa).
    answers : AnswerWords
        Code for yes, and number of alternatives in a forced-choice task.
    levels : dict
        Stimulus level for each response column of a wide table (one row per participant).
    table : Cells
        Decimal mark and sheet, which are needed only if they cannot be detected. ``only`` selects
        the rows with given values (column -> value or list of alternative values).
    analysis : AnalysisChoices
        Analysis choices, as in a study file.
    """

    columns: Columns = OWN
    stimulus: StimulusWords = StimulusWords()
    answers: AnswerWords = AnswerWords()
    levels: dict[ColumnName, Annotated[float, Field(ge=0, le=1e100)]] = Field(default_factory=dict)
    table: Cells = Cells()
    analysis: AnalysisChoices = AnalysisChoices()

    @model_validator(mode="after")
    def _one_task(self) -> TableMapping:
        try:
            _ = self.stimulus.factor
        except UserError as error:
            raise ValueError(str(error)) from None
        kinds = (
            (self.of_own, self._own),
            (self.of_pairs, self._pairs),
            (bool(self.levels), self._wide),
            (True, self._narrow),
        )
        rules = next(rules for applies, rules in kinds if applies)
        for wrong, expected in rules():
            if wrong:
                raise ValueError(expected)
        names = self.columns.model_dump().values()
        used = [name for name in names if name] + list(self.levels)
        if duplicates := sorted({name for name in used if used.count(name) > 1}):
            raise ValueError(f"column {duplicates[0]} is used twice; expected different columns")
        return self

    def _own(self) -> tuple[tuple[bool, str], ...]:
        """Check a table with Slipscale's columns; return (violated, message) for each rule."""
        others = (self.stimulus, self.answers, self.levels)
        return (
            (
                others != (StimulusWords(), AnswerWords(), {}),
                "expected columns, at least for the participant, with stimulus, answers or levels",
            ),
        )

    def _pairs(self) -> tuple[tuple[bool, str], ...]:
        """Check a table of rated pairs; return (violated, message) for each rule."""
        pair = {"first", "second", "dissimilarity"}
        others = {"participant", "session", "run", "trial", "group"}
        columns = self.columns.model_dump(exclude_none=True)
        return (
            (
                not pair <= set(columns),
                "expected columns for the first item, the second item and the dissimilarity",
            ),
            (
                bool(set(columns) - pair - others or self.levels),
                (
                    "in a table of rated pairs, the only other columns can be "
                    "participant, session, run, trial and group, and levels are not possible"
                ),
            ),
        )

    def _wide(self) -> tuple[tuple[bool, str], ...]:
        """Check a wide table; return (violated, message) for each rule."""
        columns = self.columns
        return (
            (
                bool(columns.response or self.of_answers or columns.stimulus or columns.reference),
                "expected either levels (a wide table) or columns for stimulus and response",
            ),
            (
                len(set(self.levels.values())) < len(self.levels),
                "expected a different level for each column",
            ),
            (bool(columns.trial), TRIAL_OF_SEVERAL),
        )

    def _narrow(self) -> tuple[tuple[bool, str], ...]:
        """Check a table with one response per row; return (violated, message) for each rule."""
        columns, answers = self.columns, self.answers
        return (
            (
                columns.stimulus is None or (columns.response is None) != self.of_answers,
                (
                    "expected columns for the stimulus and for the response or answer (yes and "
                    "no, or yes_count and n), or levels for a wide table"
                ),
            ),
            (
                bool(columns.yes_count) != bool(columns.n)
                or bool(columns.yes_count and columns.answer),
                (
                    "expected both yes_count and n (numbers of yes answers and of all answers), "
                    "without a column of answers"
                ),
            ),
            (
                bool(columns.response) and answers != AnswerWords(),
                "codes and 'alternatives' can be set only if there is a column of yes/no answers",
            ),
            (
                bool(columns.yes_count and (answers.yes or answers.no or answers.missing)),
                "codes for answers require a column of answers, because counts have no codes",
            ),
            (bool(columns.yes_count and columns.trial), TRIAL_OF_SEVERAL),
            (
                bool(columns.reference and columns.response),
                "a reference requires a column of answers (yes and no)",
            ),
        )

    @property
    def of_own(self) -> bool:
        """Whether the table has Slipscale's columns, so that only its format is described."""
        return not self.columns.participant

    @property
    def of_pairs(self) -> bool:
        """Whether the table contains ratings of pairs."""
        columns = self.columns
        return bool(columns.first or columns.second or columns.dissimilarity)

    @property
    def of_answers(self) -> bool:
        """Whether the table contains answers instead of magnitude estimates."""
        return bool(self.columns.answer or self.columns.yes_count)

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


def column_name(name: str, unit: str) -> str:
    """Return a quantity's column name in output files.

    >>> column_name("sound pressure", "µPa")
    'sound_pressure_uPa'
    """
    text = f"{name}_{unit}".replace("µ", "u").replace("μ", "u").replace("/", "_per_")
    return re.sub(r"\W+", "_", text).strip("_")


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
            "{file}: cannot be written ({reason})", file=file, reason=error.strerror
        ) from error
    return file
