"""What declarations of kinds of task share."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from slipscale.analysis.writing.numbers import counted

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas as pd

    from slipscale.analysis.reading.labelled_tasks import TaskTrials
    from slipscale.analysis.result import Analysis
    from slipscale.analysis.statistics.statistic import Statistic

T = TypeVar("T")


def run_trials(trials: TaskTrials, what: str) -> Callable[[Analysis], list[str]]:
    """Return what counts the trials for the summary's design."""

    def design(analysis: Analysis) -> list[str]:
        rows = len(analysis.dataset.of(trials))
        return [f"{counted(rows, 'trial', 'trials')} of {what}"] if rows else []

    return design


def tables_of(
    name: str, statistic: Statistic[T], table: Callable[[T], pd.DataFrame]
) -> Callable[[Analysis], dict[str, pd.DataFrame]]:
    """Return what writes a result as one table."""

    def tables(analysis: Analysis) -> dict[str, pd.DataFrame]:
        found = analysis.inference.found(statistic)
        return {} if found is None else {name: table(found)}

    return tables
