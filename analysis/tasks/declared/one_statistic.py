"""Declare a kind of task that has one result per task."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Generic, TypeAlias, TypeVar, cast

import pandas as pd

from slipscale.analysis.tasks.kind import Analysis, TaskAnalysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import counted
from slipscale.analysis.writing.task_names import task_name

if TYPE_CHECKING:
    from markupsafe import Markup
    from matplotlib.figure import Figure

    from slipscale.analysis.json_form import JsonObject
    from slipscale.analysis.reading.labelled_tasks import TaskTrials
    from slipscale.stimuli.quantity import Quantity

T = TypeVar("T")
Svgs: TypeAlias = Mapping[str, str]
Figures: TypeAlias = "Mapping[str, Figure]"
Blocks: TypeAlias = "list[Markup]"


class OneStatistic(TaskAnalysis, Generic[T]):
    """A kind of task whose first statistic has one result per task.

    The methods ``task_...`` describe the result of one task. The question and the heading are
    format strings with the quantity of the levels as ``q``.

    Attributes
    ----------
    question, what, title : str
        Question for the summary, name of the trials (such as "matching"), and heading of the
        sentences in the results section.
    heading : str
        Heading of the section. The default is ``title``.
    """

    trials: TaskTrials
    question: str
    what: str
    title: str
    heading: str = ""

    def task_name(self, task: T, _quantity: Quantity, /) -> str:
        """Return the name of a task, with its label and condition."""
        return task_name(self.title, task.task)  # type: ignore[attr-defined]  # or it is overridden

    def task_answer(self, task: T, confidence: float, quantity: Quantity, /) -> str:
        """Return the sentence for the summary."""
        raise NotImplementedError

    def task_answers(self, task: T, confidence: float, quantity: Quantity, /) -> list[str]:
        """Return all sentences for the summary."""
        return [self.task_answer(task, confidence, quantity)]

    def task_remarks(self, _task: T, _confidence: float, _quantity: Quantity, /) -> list[str]:
        """Return additional sentences for the results section."""
        return []

    def task_doubts(self, _task: T, _confidence: float, _quantity: Quantity, /) -> list[str]:
        """Return caveats."""
        return []

    def task_blocks(self, task: T, svgs: Svgs, percent: float, quantity: Quantity, /) -> Blocks:
        """Return the content of the section, given the figures and the confidence level in %."""
        raise NotImplementedError

    def task_figures(self, task: T, trials: pd.DataFrame, quantity: Quantity, /) -> Figures:
        """Return figures, keyed by file name, given the trials of all tasks."""
        raise NotImplementedError

    def task_rows(self, task: T) -> Sequence[JsonObject]:
        """Return rows of the CSV table.

        Column names are for amplitudes in µm; for another quantity, the columns are renamed.
        """
        raise NotImplementedError

    def tasks(self, analysis: Analysis) -> Sequence[T]:
        """Return the results, one per task."""
        found = analysis.inference.found(self.statistics[0])
        return cast("Sequence[T]", () if found is None else found)

    def questions(self, analysis: Analysis) -> list[str]:
        """Return the question, if there is a result."""
        if analysis.inference.found(self.statistics[0]) is None:
            return []
        return [self.question.format(q=analysis.dataset.quantity)]

    def design(self, analysis: Analysis) -> list[str]:
        """Return the number of trials."""
        count = len(analysis.dataset.of(self.trials))
        return [counted(count, f"{self.what} trial", f"{self.what} trials")] if count else []

    def answers(self, analysis: Analysis) -> list[str]:
        """Return the answers of all tasks."""
        level, quantity = analysis.dataset.choices.confidence, analysis.dataset.quantity
        tasks = self.tasks(analysis)
        return [text for task in tasks for text in self.task_answers(task, level, quantity)]

    def doubts(self, analysis: Analysis) -> list[str]:
        """Return the caveats of all tasks."""
        level, quantity = analysis.dataset.choices.confidence, analysis.dataset.quantity
        tasks = self.tasks(analysis)
        return [text for task in tasks for text in self.task_doubts(task, level, quantity)]

    def sentences(self, analysis: Analysis) -> Mapping[str, list[str]]:
        """Return each task's answers, and its remarks in a paragraph that names the task."""
        level, quantity = analysis.dataset.choices.confidence, analysis.dataset.quantity
        tasks, texts = self.tasks(analysis), []
        for task in tasks:
            lead = f"{self.task_name(task, quantity)}: " if len(tasks) > 1 else ""
            texts += self.task_answers(task, level, quantity)
            if further := " ".join(self.task_remarks(task, level, quantity)):
                texts.append(lead + further)
        return {self.title: texts}

    def figures(self, analysis: Analysis) -> Mapping[str, Figure]:
        """Return the figures of all tasks."""
        trials, quantity = analysis.dataset.of(self.trials), analysis.dataset.quantity
        found: dict[str, Figure] = {}
        for task in self.tasks(analysis):
            found |= self.task_figures(task, trials, quantity)
        return found

    def tables(self, analysis: Analysis) -> Mapping[str, pd.DataFrame]:
        """Return one table with the rows of all tasks."""
        if analysis.inference.found(self.statistics[0]) is None:
            return {}
        rows = [row for task in self.tasks(analysis) for row in self.task_rows(task)]
        return {self.name: analysis.dataset.quantity.columns(pd.DataFrame(rows))}

    def sections(self, analysis: Analysis, svgs: Mapping[str, str]) -> Iterable[ReportSection]:
        """Return a section with the content of all tasks."""
        closed = analysis.prepared is not None  # magnitude estimates come first in the report
        quantity, percent = analysis.dataset.quantity, 100 * analysis.dataset.choices.confidence
        head = (self.heading or self.title).format(q=quantity)
        written = ReportSection(head, shown="closed" if closed else "open")
        for task in self.tasks(analysis):
            name = self.task_name(task, quantity)
            # A heading that would repeat the section's heading is omitted.
            written.blocks += [] if name == head else [html.heading(name)]
            written.blocks += self.task_blocks(task, svgs, percent, quantity)
        return [written]
