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

T = TypeVar("T")
TaskBlocks: TypeAlias = "Callable[[T, Mapping[str, str], float], list[Markup]]"


def of_one_statistic(
    name: str,
    trials: TaskTrials,
    statistic: Statistic[T],
    *,
    question: str,
    what: str,
    title: str,
    answers: Callable[[T, float], list[str]],
    sentences: Callable[[T, float], list[str]],
    heading: str = "",
    blocks: TaskBlocks[T],
    figures: Callable[[T, pd.DataFrame], Mapping[str, Figure]],
    table: Callable[[T], pd.DataFrame],
    **others: Any,
) -> TaskAnalysis:
    """Return the declaration of a kind whose texts and figures follow from one result.

    Parameters
    ----------
    question, what, title : str
        The summary's question, the name of the trials, and the heading of the sentences.
    answers, sentences : callable
        Return texts from the result and the confidence level.
    heading : str
        The section's heading; default: as for the sentences.
    blocks : callable
        Returns the section's blocks from the result, the figures and the confidence level in %.
    figures : callable
        Returns figures by file name from the result and the trials.
    table : callable
        Returns the CSV table of the result.
    others
        Further fields of `TaskAnalysis`.
    """

    def design(analysis: Analysis) -> list[str]:
        rows = len(analysis.dataset.of(trials))
        return [f"{counted(rows, 'trial', 'trials')} of {what}"] if rows else []

    def written(analysis: Analysis, write: Callable[[T, float], list[str]]) -> list[str]:
        found = analysis.inference.found(statistic)
        return [] if found is None else write(found, analysis.dataset.choices.confidence)

    def drawn(analysis: Analysis) -> Mapping[str, Figure]:
        found = analysis.inference.found(statistic)
        return {} if found is None else figures(found, analysis.dataset.of(trials))

    def tables(analysis: Analysis) -> dict[str, pd.DataFrame]:
        found = analysis.inference.found(statistic)
        return {} if found is None else {name: table(found)}

    def section(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
        closed = analysis.prepared is not None  # magnitude estimates come first in the report
        written = ReportSection(heading or title, shown="closed" if closed else "open")
        found = analysis.inference.found(statistic)
        if found is not None:
            written.blocks += blocks(found, svgs, 100 * analysis.dataset.choices.confidence)
        return written

    return TaskAnalysis(
        name=name,
        trials=trials,
        statistics=(statistic,),
        questions=lambda analysis: written(analysis, lambda _found, _level: [question]),
        design=design,
        answers=lambda analysis: written(analysis, answers),
        sentences=lambda analysis: {title: written(analysis, sentences)},
        sections=(section,),
        figures=drawn,
        tables=tables,
        **others,
    )
