"""Declare another package's kind of task, given a single analysis function.

`own_analysis` returns the `TaskAnalysis` for an entry point. All values from the package are
validated when they are created, so that error messages can name the package.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import pandas as pd

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Inputs, Statistic
from slipscale.analysis.tasks.kind import Analysis, TaskAnalysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import DASH, significant
from slipscale.experiments.study.file import parse_study
from slipscale.faults import UserError

if TYPE_CHECKING:
    from markupsafe import Markup
    from matplotlib.figure import Figure

    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.experiments.study.model import Study

CELL = (str, int, float, bool, type(None))
#: Largest number of table rows in the report; the CSV file contains all rows.
ROWS_SHOWN = 40


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnInput:
    """The input of an analysis function that another package provides.

    Parameters
    ----------
    dataset : Dataset
        Trials, participants and analysis choices. Excluded participants and trials are omitted, and
        tables are copies. Tables of tasks that Slipscale does not analyse are in
        ``dataset.others``.
    study : Study or None
        The study, or None if the data set has no readable study file.
    """

    dataset: Dataset
    study: Study | None


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnResult:
    """The result of an analysis function that another package provides.

    Parameters
    ----------
    sentences : tuple of str
        At least one sentence for the results section.
    numbers : Mapping
        Content for inference.json: a mapping from names to numbers, strings, None, or tuples or
        mappings of these. Names include the unit, as in ``slope_per_um_pp``. NaN is written as
        null.
    table : DataFrame, optional
        Table of numbers and strings, with named columns.
    table_caption : str
        Description of the table.
    figure : Figure, optional
        A Matplotlib figure.
    figure_caption, figure_alt : str
        Caption, and text alternative for people who cannot see the figure. A figure requires both.

    Raises
    ------
    UserError
        A field has the wrong type, or a figure has no caption or text alternative. The error
        message names the field.
    """

    sentences: tuple[str, ...]
    numbers: Mapping[str, object]
    table: pd.DataFrame | None = None
    table_caption: str = ""
    figure: Figure | None = None
    figure_caption: str = ""
    figure_alt: str = ""

    def __post_init__(self) -> None:
        wrong = (
            (
                not isinstance(self.sentences, tuple)
                or not self.sentences
                or not all(isinstance(each, str) and each.strip() for each in self.sentences),
                "sentences: expected a tuple of one or more strings",
            ),
            (
                not isinstance(self.numbers, Mapping) or not _is_plain(self.numbers),
                (
                    "numbers: expected a mapping from names to numbers, strings, None, "
                    "and tuples or mappings of these"
                ),
            ),
            (
                self.table is not None and not _is_table(self.table),
                "table: expected a DataFrame of numbers and strings with unique, named columns",
            ),
            (
                self.figure is not None and not (self.figure_caption and self.figure_alt),
                "figure: a figure_caption and a figure_alt are also required",
            ),
        )
        if faults := [words for fault, words in wrong if fault]:
            raise UserError("; ".join(faults))

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return {"sentences": self.sentences, "numbers": self.numbers}


def own_analysis(
    name: str, *, title: str, run: Callable[[OwnInput], OwnResult | NotComputed]
) -> TaskAnalysis:
    """Return the kind of task for an entry point of the group ``slipscale.analyses``.

    Parameters
    ----------
    name : str
        Name of the entry point. Files and the key in inference.json are called ``own_NAME``.
    title : str
        Heading of the section in the report.
    run : callable
        Returns an `OwnResult`, or `NotComputed` with the reason why there is no result.
    """
    if not isinstance(title, str) or not title.strip():
        raise UserError(f"analysis '{name}': the title must contain text, but is {title!r}")
    return _Short(name, title, run)


class _ShortStatistic(Statistic[OwnResult]):
    def __init__(
        self, key: str, meaning: str, run: Callable[[OwnInput], OwnResult | NotComputed]
    ) -> None:
        self.key, self.meaning, self._run = key, meaning, run

    def compute(self, inputs: Inputs) -> OwnResult | NotComputed:
        found = self._run(OwnInput(dataset=inputs.data, study=study_of(inputs.data)))
        if not isinstance(found, OwnResult | NotComputed):
            raise UserError(
                f"returned {type(found).__name__}, expected an OwnResult or NotComputed"
            )
        return found


class _Short(TaskAnalysis):
    """A kind of task that shows an `OwnResult`."""

    def __init__(
        self, name: str, title: str, run: Callable[[OwnInput], OwnResult | NotComputed]
    ) -> None:
        self.name, self.title = name, title
        self.key = f"own_{name}"
        self.statistic = _ShortStatistic(self.key, title, run)
        self.statistics = (self.statistic,)

    def answers(self, analysis: Analysis) -> list[str]:
        return [f"{self.title}: {text}" for text in self._texts(analysis)]

    def sentences(self, analysis: Analysis) -> Mapping[str, list[str]]:
        return {self.title: self._texts(analysis)}

    def figures(self, analysis: Analysis) -> Mapping[str, Figure]:
        found = analysis.inference.found(self.statistic)
        return {} if found is None or found.figure is None else {self.key: found.figure}

    def tables(self, analysis: Analysis) -> Mapping[str, pd.DataFrame]:
        found = analysis.inference.found(self.statistic)
        return {} if found is None or found.table is None else {self.key: found.table}

    def sections(self, analysis: Analysis, svgs: Mapping[str, str]) -> list[ReportSection]:
        found = analysis.inference[self.statistic]
        written = ReportSection(self.title, shown="open")
        if isinstance(found, NotComputed):
            written.blocks.append(html.paragraph(f"Not computed: {found.reason}."))
            return [written]
        if (svg := svgs.get(self.key)) is not None:
            written.blocks.append(html.figure(svg, found.figure_caption, found.figure_alt))
        if found.table is not None:
            written.blocks.append(_table(self.key, found.table, found.table_caption))
        return [written]

    def _texts(self, analysis: Analysis) -> list[str]:
        found = analysis.inference.found(self.statistic)
        return [] if found is None else list(found.sentences)


def study_of(data: Dataset) -> Study | None:
    """Read the study file of a data set; return None if it is missing or cannot be read."""
    path = data.folder / "code" / "study.toml" if data.folder else None
    if path is None or not path.is_file():
        return None
    try:
        return parse_study(path.read_text(encoding="utf-8-sig"), str(path))
    except (OSError, UnicodeDecodeError, UserError):
        return None


def _table(key: str, table: pd.DataFrame, caption: str) -> Markup:
    shown = table.head(ROWS_SHOWN)
    more = len(table) - len(shown)
    left = f" The first {len(shown)} of {len(table)} rows; all are in {key}.csv."
    numeric = [kind.kind in "iuf" for kind in table.dtypes]
    return html.table(
        [
            TableColumn(title=str(title), left=not is_number)
            for title, is_number in zip(table.columns, numeric, strict=True)
        ],
        [[_cell(cell) for cell in row] for row in shown.itertuples(index=False)],
        f"{caption}{left if more else ''}".strip(),
    )


def _cell(value: object) -> str:
    if value is None or value != value:  # noqa: PLR0124 - only NaN differs from itself
        return DASH
    return significant(value) if isinstance(value, float) else str(value)


def _is_plain(value: object) -> bool:
    """Return whether a value can be written as JSON."""
    if isinstance(value, Mapping):
        return all(isinstance(key, str) and _is_plain(each) for key, each in value.items())
    if isinstance(value, tuple | list):
        return all(_is_plain(each) for each in value)
    return isinstance(value, CELL)


def _is_table(table: object) -> bool:
    if not isinstance(table, pd.DataFrame) or not len(table.columns):
        return False
    named = all(isinstance(name, str) and name for name in table.columns)
    plain = (all(isinstance(cell, CELL) for cell in table[name].tolist()) for name in table)
    return named and table.columns.is_unique and all(plain)
