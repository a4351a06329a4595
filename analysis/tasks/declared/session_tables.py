"""Compute tables of participants by sessions, which are used to compare sessions."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pandas as pd

from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.reading.labelled_tasks import TaskTrials
from slipscale.analysis.reading.task_tables import by_task
from slipscale.analysis.statistics.statistic import SessionTable
from slipscale.experiments.dataset.schema import PARTICIPANT


def by_session(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the mean of ``value`` for each participant (rows) and session (columns)."""
    return rows.assign(session=rows["session"].astype(str)).pivot_table(
        index=PARTICIPANT, columns="session", values="value", observed=True
    )


def logarithms(values: pd.Series[float]) -> pd.Series[float]:
    """Return natural logarithms, or NaN for values that are not above 0."""
    return pd.Series(np.log(values.where(values > 0).to_numpy(float)), index=values.index)


def mean_by_session(
    data: Dataset,
    trials: TaskTrials,
    what: str,
    unit: str,
    value: Callable[[pd.DataFrame], pd.Series[float]],
) -> Iterator[SessionTable]:
    """Yield a table of session means for each task, without catch trials.

    ``what`` and ``unit`` are format strings with the quantity as ``q``.
    """
    for task, rows in by_task(data.of(trials)):
        main = rows[~rows["catch"]] if "catch" in rows else rows
        name = f"{task}, {what.format(q=data.quantity)}"
        yield name, unit.format(q=data.quantity), by_session(main.assign(value=value(main)))
