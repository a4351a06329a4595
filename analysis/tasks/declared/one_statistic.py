"""Declare a kind of task that has a single statistic."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import pandas as pd

from slipscale.analysis.tasks.kind import Analysis, TaskAnalysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import counted

if TYPE_CHECKING:
    from markupsafe import Markup
    from matplotlib.figure import Figure

    from slipscale.analysis.json_form import JsonObject
    from slipscale.analysis.reading.labelled_tasks import TaskTrials
    from slipscale.analysis.statistics.statistic import Statistic
    from slipscale.stimuli.quantity import Quantity

R = TypeVar("R")
T = TypeVar("T")
TaskTexts: TypeAlias = "Callable[[T, float, Quantity], list[str]]"


def _none(_task: object, _level: float, _quantity: Quantity) -> list[str]:
    return []


def _concluding(
    answers: TaskTexts[T], remarks: TaskTexts[T], named: Callable[[T, Quantity], str] | None
) -> TaskTexts[T]:
    """Return a function that writes a task's answers, followed by its remarks in one paragraph.

    If ``named`` is given, the paragraph begins with the task's name.
    """

    def write(task: T, level: float, quantity: Quantity) -> list[str]:
        further = " ".join(remarks(task, level, quantity))
        lead = f"{named(task, quantity)}: " if named else ""
        return [*answers(task, level, quantity), *([lead + further] if further else [])]

    return write


def _design(count: int, what: str) -> list[str]:
    return [counted(count, f"{what} trial", f"{what} trials")] if count else []


def _heading(name: str, head: str) -> list[Markup]:
    """Return the task's heading, or nothing if it would repeat the section's heading."""
    return [] if name == head else [html.heading(name)]


def of_one_statistic(
    name: str,
    trials: TaskTrials,
    statistic: Statistic[R],
    *,
    tasks: Callable[[R], Iterable[T]] = tuple,  # type: ignore[assignment]  # of a tuple
    question: str,
    what: str,
    title: str,
    named: Callable[[T, Quantity], str],
    answers: TaskTexts[T],
    remarks: TaskTexts[T] = _none,
    doubts: TaskTexts[T] = _none,
    heading: str = "",
    blocks: Callable[[T, Mapping[str, str], float, Quantity], list[Markup]],
    figures: Callable[[T, pd.DataFrame, Quantity], Mapping[str, Figure]],
    rows: Callable[[T], Sequence[JsonObject]],
    **others: Any,
) -> TaskAnalysis:
    """Declare a kind of task from functions that describe the result for one task.

    Every callable except ``tasks`` is called once per task. Every callable except ``tasks`` and
    ``rows`` receives the quantity of the levels as its last argument. The question and the heading
    are format strings with the quantity as ``q``.

    Parameters
    ----------
    tasks : callable
        Function that splits the statistic's result into one result per task. It can be omitted if
        the result is a sequence with one item per task.
    question, what, title : str
        Question for the summary, name of the trials (such as "matching"), and heading of the
        sentences in the results section.
    named : callable
        Returns the name of a task, with its label and condition.
    answers, remarks, doubts : callable
        Return sentences for the summary, additional sentences for the results section, and caveats,
        given the result and the confidence level.
    heading : str
        Heading of the section. The default is ``title``.
    blocks : callable
        Returns the content of the section, given the result, the figures and the confidence level
        in %.
    figures : callable
        Returns figures, keyed by file name, given the task's result and the trials of all tasks.
    rows : callable
        Returns rows of the CSV table. Column names are for amplitudes in µm; for another stimulus
        quantity, the columns are renamed.
    others : object
        Further fields of `TaskAnalysis`.
    """

    def results(analysis: Analysis) -> Iterable[T]:
        found = analysis.inference.found(statistic)
        return () if found is None else tasks(found)

    def asked(analysis: Analysis) -> list[str]:
        found = analysis.inference.found(statistic)
        return [] if found is None else [question.format(q=analysis.dataset.quantity)]

    def written(analysis: Analysis, write: TaskTexts[T]) -> list[str]:
        level, quantity = analysis.dataset.choices.confidence, analysis.dataset.quantity
        return [text for task in results(analysis) for text in write(task, level, quantity)]

    def concluded(analysis: Analysis) -> dict[str, list[str]]:
        several = len(list(results(analysis))) > 1
        of_task = _concluding(answers, remarks, named if several else None)
        return {title: written(analysis, of_task)}

    def drawn(analysis: Analysis) -> Mapping[str, Figure]:
        own, quantity = analysis.dataset.of(trials), analysis.dataset.quantity
        return {
            name: figure
            for task in results(analysis)
            for name, figure in figures(task, own, quantity).items()
        }

    def tables(analysis: Analysis) -> dict[str, pd.DataFrame]:
        if analysis.inference.found(statistic) is None:
            return {}
        table = pd.DataFrame([row for task in results(analysis) for row in rows(task)])
        return {name: analysis.dataset.quantity.columns(table)}

    def section(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
        closed = analysis.prepared is not None  # magnitude estimates come first in the report
        quantity, level = analysis.dataset.quantity, 100 * analysis.dataset.choices.confidence
        head = (heading or title).format(q=quantity)
        written = ReportSection(head, shown="closed" if closed else "open")
        for task in results(analysis):
            written.blocks += _heading(named(task, quantity), head)
            written.blocks += blocks(task, svgs, level, quantity)
        return written

    return TaskAnalysis(
        name=name,
        trials=trials,
        statistics=(statistic,),
        questions=asked,
        design=lambda analysis: _design(len(analysis.dataset.of(trials)), what),
        answers=lambda analysis: written(analysis, answers),
        doubts=lambda analysis: written(analysis, doubts),
        sentences=concluded,
        sections=(section,),
        figures=drawn,
        tables=tables,
        **others,
    )
