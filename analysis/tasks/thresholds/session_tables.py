"""Compute thresholds for each participant and session."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.reading.task_tables import by_task
from slipscale.analysis.statistics.psychometrics.psychometric_function import Answers
from slipscale.analysis.statistics.psychometrics.thresholds import threshold_values
from slipscale.analysis.tasks.thresholds.reading import TRIALS
from slipscale.analysis.tasks.thresholds.statistics import CURVE_OF
from slipscale.experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from collections.abc import Iterator

    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.analysis.statistics.statistic import SessionTable


def session_tables(data: Dataset, _prepared: Prepared | None) -> Iterator[SessionTable]:
    """Yield log10 thresholds, participants by sessions; NaN if they cannot be determined."""
    for task, rows in by_task(data.of(TRIALS)):
        yield f"{task}, threshold", f"log10 {data.quantity.unit_in_short}", _thresholds(rows)


def _thresholds(rows: pd.DataFrame) -> pd.DataFrame:
    """Return log10 thresholds, participants by sessions; NaN if they cannot be determined."""
    main = rows[~rows["catch"]]
    method = str(rows["method"].iloc[0])
    keys = [main[PARTICIPANT].astype(str), main["session"].astype(str)]
    answers = {
        key: Answers.of_trials(own["level_um_pp"].tolist(), own["correct"].tolist())
        for key, own in main.groupby(keys)
    }
    values = threshold_values(
        list(answers.values()), method=method, curve=CURVE_OF.get(method, "weibull")
    )
    logs = np.log10(np.where(values > 0, values, np.nan))
    found: dict[str, dict[str, float]] = {}
    for (who, session), log in zip(answers, logs, strict=True):
        found.setdefault(str(session), {})[str(who)] = float(log)
    return pd.DataFrame(found)
