"""Read method-of-limits trials: series, direction, level, and whether it felt different."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.answer_codes import own_answers
from slipscale.analysis.reading.task_tables import task_trials

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.reading.delimited import Problems


def _coded(frame: pd.DataFrame, _problems: Problems) -> pd.DataFrame:
    return frame.assign(felt=own_answers(frame["different"]))


TRIALS = task_trials(
    "limits",
    "trial of the method of limits",
    marks=("series", "direction", "comparison_um_pp", "different"),
    numeric=("series", "comparison_um_pp", "standard_um_pp"),
    words=("direction", "different"),
    columns=("series", "direction", "comparison_um_pp", "standard_um_pp", "felt"),
    needed=("felt", "comparison_um_pp", "series"),
    levels=("comparison_um_pp", "standard_um_pp"),
    derive=_coded,
)
