"""Declare a kind of task with trials and a single statistic, including its section."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from slipscale.analysis.tasks.kind import TaskAnalysis
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import counted

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import pandas as pd
    from markupsafe import Markup
    from matplotlib.figure import Figure

    from slipscale.analysis.reading.labelled_tasks import TaskTrials
    from slipscale.analysis.statistics.statistic import Statistic
    from slipscale.analysis.tasks.kind import Analysis
    from slipscale.stimuli.quantity import Quantity

T = TypeVar("T")
TaskBlocks: TypeAlias = "Callable[[T, Mapping[str, str], float, Quantity], list[Markup]]"
TaskTexts: TypeAlias = "Callable[[T, float, Quantity], list[str]]"


def of_each(
    blocks: Callable[[T, Mapping[str, str], float, Quantity], list[Markup]],
) -> TaskBlocks[tuple[T, ...]]:
    """Return a function that writes the blocks of each task of a result, one task after another."""

    def every(
        tasks: tuple[T, ...], svgs: Mapping[str, str], level: float, quantity: Quantity
    ) -> list[Markup]:
        return [block for task in tasks for block in blocks(task, svgs, level, quantity)]

    return every


def of_one_statistic(
    name: str,
    trials: TaskTrials,
    statistic: Statistic[T],
    *,
    question: str,
    what: str,
    title: str,
    answers: TaskTexts[T],
    sentences: TaskTexts[T],
    heading: str = "",
    blocks: TaskBlocks[T],
    figures: Callable[[T, pd.DataFrame, Quantity], Mapping[str, Figure]],
    table: Callable[[T], pd.DataFrame],
    doubts: TaskTexts[T] | None = None,
    **others: Any,
) -> TaskAnalysis:
    """Return the declaration of a kind whose texts and figures are based on one result.

    Every callable also receives the quantity of the levels; texts have placeholders for it.

    Parameters
    ----------
    question, what, title : str
        Question in the summary, name of the trials, and heading of the sentences.
    answers, sentences, doubts : callable
        Return texts, given the result and the confidence level.
    heading : str
        Heading of the section; default: as for the sentences.
    blocks : callable
        Returns the section's blocks, given the result, the figures and the confidence level in %.
    figures : callable
        Returns figures, keyed by file name, given the result and the trials.
    table : callable
        Returns the CSV table for the result, with the column names of a file in µm.
    others
        Further fields of `TaskAnalysis`.
    """

    def design(analysis: Analysis) -> list[str]:
        rows = len(analysis.dataset.of(trials))
        return [f"{counted(rows, 'trial', 'trials')} of {what}"] if rows else []

    def written(analysis: Analysis, write: TaskTexts[T]) -> list[str]:
        found, data = analysis.inference.found(statistic), analysis.dataset
        return [] if found is None else write(found, data.choices.confidence, data.quantity)

    def asked(_found: T, _level: float, quantity: Quantity) -> list[str]:
        return [question.format(q=quantity)]

    def drawn(analysis: Analysis) -> Mapping[str, Figure]:
        found, data = analysis.inference.found(statistic), analysis.dataset
        return {} if found is None else figures(found, data.of(trials), data.quantity)

    def tables(analysis: Analysis) -> dict[str, pd.DataFrame]:
        found = analysis.inference.found(statistic)
        named = analysis.dataset.quantity.columns
        return {} if found is None else {name: named(table(found))}

    def section(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
        closed = analysis.prepared is not None  # magnitude estimates come first in the report
        found, data = analysis.inference.found(statistic), analysis.dataset
        head = (heading or title).format(q=data.quantity)
        written = ReportSection(head, shown="closed" if closed else "open")
        if found is not None:
            written.blocks += blocks(found, svgs, 100 * data.choices.confidence, data.quantity)
        return written

    return TaskAnalysis(
        name=name,
        trials=trials,
        statistics=(statistic,),
        questions=lambda analysis: written(
            analysis, lambda _found, _level, q: [question.format(q=q)]
        ),
        design=design,
        answers=lambda analysis: written(analysis, answers),
        doubts=lambda analysis: written(analysis, doubts) if doubts else [],
        sentences=lambda analysis: {title: written(analysis, sentences)},
        sections=(section,),
        figures=drawn,
        tables=tables,
        **others,
    )
