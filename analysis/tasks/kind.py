"""What a kind of task declares to the analysis: the counterpart of a session's `Protocol`.

A folder below `slipscale.analysis.tasks` holds one kind. Its ``declaration`` names everything that
the report and its files show of it, and `slipscale.analysis.tasks.table` lists the declarations.
The rules:

- the centre (loading, inference, page, files, plans) loops over the table and names no kind;
- every callable takes the whole `Analysis` and returns nothing if the kind was not run.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    import pandas as pd
    from matplotlib.figure import Figure

    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.analysis.reading.labelled_tasks import TaskTrials
    from slipscale.analysis.result import Analysis
    from slipscale.analysis.statistics.statistic import SessionTable, Statistic
    from slipscale.analysis.writing.html import ReportSection

    SectionWriter = Callable[[Analysis, Mapping[str, str]], ReportSection]


def _nothing_to_say(_analysis: Analysis) -> list[str]:
    return []


def _nothing_titled(_analysis: Analysis) -> dict[str, list[str]]:
    return {}


def _no_figures(_analysis: Analysis) -> dict[str, Figure]:
    return {}


def _no_tables(_analysis: Analysis) -> dict[str, pd.DataFrame]:
    return {}


def _no_sessions(_data: Dataset, _prepared: Prepared | None) -> tuple[SessionTable, ...]:
    return ()


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskAnalysis:
    """One kind of task, as the analysis knows it.

    Parameters
    ----------
    name : str
        Its folder's name.
    trials : TaskTrials, optional
        Which tables hold its trials, and how they are read; a study may give such a task a label.
    statistics : tuple of Statistic
        In the order in which they are computed, and of ``inference.json``.
    questions : callable
        Returns the questions that the report's summary opens with.
    design : callable
        Returns how many trials of which surfaces there were.
    answers : callable
        Returns the summary's sentences.
    doubts : callable
        Returns what the summary tells a reader to doubt.
    sentences : callable
        Returns the results section: heading -> sentences.
    sections : tuple of callable
        Each returns a section of the report from the analysis and the figures, SVG by name.
    figures : callable
        Returns the figures by file name.
    tables : callable
        Returns the tables by file name.
    session_tables : callable
        Returns the measures of a participant's session.
    """

    name: str
    trials: TaskTrials | None = None
    statistics: tuple[Statistic[object], ...] = ()
    questions: Callable[[Analysis], list[str]] = _nothing_to_say
    design: Callable[[Analysis], list[str]] = _nothing_to_say
    answers: Callable[[Analysis], list[str]] = _nothing_to_say
    doubts: Callable[[Analysis], list[str]] = _nothing_to_say
    sentences: Callable[[Analysis], Mapping[str, list[str]]] = _nothing_titled
    sections: tuple[SectionWriter, ...] = ()
    figures: Callable[[Analysis], Mapping[str, Figure]] = _no_figures
    tables: Callable[[Analysis], Mapping[str, pd.DataFrame]] = _no_tables
    session_tables: Callable[[Dataset, Prepared | None], Iterable[SessionTable]] = _no_sessions
