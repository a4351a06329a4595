"""Declare a kind of task that has a single statistic."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import pandas as pd

from slipscale.analysis.tasks.kind import Analysis, TaskAnalysis
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


def of_one_statistic(
    name: str,
    trials: TaskTrials,
    statistic: Statistic[R],
    *,
    tasks: Callable[[R], Iterable[T]] = tuple,  # type: ignore[assignment]  # of a tuple
    question: str,
    what: str,
    title: str,
    answers: TaskTexts[T],
    sentences: TaskTexts[T] | None = None,
    doubts: TaskTexts[T] = _none,
    heading: str = "",
    blocks: Callable[[T, Mapping[str, str], float, Quantity], list[Markup]],
    figures: Callable[[T, pd.DataFrame, Quantity], Mapping[str, Figure]],
    rows: Callable[[T], Sequence[JsonObject]],
    **others: Any,
) -> TaskAnalysis:
    """Return the declaration of a kind of task whose texts and figures use one result per task.

    Every callable except ``tasks`` is called once per task. The last argument of every callable
    except ``tasks`` and ``rows`` is the quantity of the levels. The question and the heading can
    contain placeholders for the quantity.

    Parameters
    ----------
    tasks : callable
        Function that splits the statistic's result into one result per task; by default, a tuple
        with one item per task.
    question, what, title : str
        Question in the summary, noun for the trials, and heading of the results sentences.
    answers, sentences, doubts : callable
        Return texts, given the result and the confidence level; ``sentences`` defaults to
        ``answers``.
    heading : str
        Heading of the section. The default is ``title``.
    blocks : callable
        Returns the blocks of the section, given the result, the figures and the confidence level in
        %.
    figures : callable
        Returns figures, keyed by file name, from the result and the trials of all tasks.
    rows : callable
        Returns rows of the CSV table, with the column names used for µm.
    others : object
        Further fields of `TaskAnalysis`.
    """

    def results(analysis: Analysis) -> Iterable[T]:
        found = analysis.inference.found(statistic)
        return () if found is None else tasks(found)

    def asked(analysis: Analysis) -> list[str]:
        found = analysis.inference.found(statistic)
        return [] if found is None else [question.format(q=analysis.dataset.quantity)]

    def design(analysis: Analysis) -> list[str]:
        count = len(analysis.dataset.of(trials))
        return [f"{counted(count, 'trial', 'trials')} of {what}"] if count else []

    def written(analysis: Analysis, write: TaskTexts[T]) -> list[str]:
        level, quantity = analysis.dataset.choices.confidence, analysis.dataset.quantity
        return [text for task in results(analysis) for text in write(task, level, quantity)]

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
            written.blocks += blocks(task, svgs, level, quantity)
        return written

    return TaskAnalysis(
        name=name,
        trials=trials,
        statistics=(statistic,),
        questions=asked,
        design=design,
        answers=lambda analysis: written(analysis, answers),
        doubts=lambda analysis: written(analysis, doubts),
        sentences=lambda analysis: {title: written(analysis, sentences or answers)},
        sections=(section,),
        figures=drawn,
        tables=tables,
        **others,
    )
