"""Declare a kind of task that has a single statistic."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain
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


def _paragraphs(
    names: list[list[str]], answers: list[list[str]], remarks: list[list[str]]
) -> list[str]:
    """Return each task's answers and remarks; with several tasks, remarks start with the name."""
    texts = []
    for (name,), own_answers, own_remarks in zip(names, answers, remarks, strict=True):
        lead = f"{name}: " if len(names) > 1 else ""
        texts += [*own_answers, *([lead + " ".join(own_remarks)] if own_remarks else [])]
    return texts


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
        Function that splits the statistic's result into one result per task. The default is for
        results that are already a sequence with one item per task.
    question, what, title : str
        Question in the summary, adjective for the trials, and heading of the results sentences.
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
        Returns rows of the CSV table, with the column names for amplitudes in µm. These are renamed
        for other quantities.
    others : object
        Further fields of `TaskAnalysis`.
    """

    def results(analysis: Analysis) -> Iterable[T]:
        found = analysis.inference.found(statistic)
        return () if found is None else tasks(found)

    def asked(analysis: Analysis) -> list[str]:
        found = analysis.inference.found(statistic)
        return [] if found is None else [question.format(q=analysis.dataset.quantity)]

    def by_task(analysis: Analysis, write: TaskTexts[T]) -> list[list[str]]:
        level, quantity = analysis.dataset.choices.confidence, analysis.dataset.quantity
        return [write(task, level, quantity) for task in results(analysis)]

    def concluded(analysis: Analysis) -> dict[str, list[str]]:
        names = by_task(analysis, lambda task, _level, quantity: [named(task, quantity)])
        return {title: _paragraphs(names, by_task(analysis, answers), by_task(analysis, remarks))}

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
        answers=lambda analysis: list(chain.from_iterable(by_task(analysis, answers))),
        doubts=lambda analysis: list(chain.from_iterable(by_task(analysis, doubts))),
        sentences=concluded,
        sections=(section,),
        figures=drawn,
        tables=tables,
        **others,
    )
