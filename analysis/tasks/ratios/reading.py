"""Read ratio judgements from a data set: ratios above 0."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.task_tables import above_zero, task_trials

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.reading.delimited import Problems

JUDGED = ("ratio", "comparison_um_pp", "standard_um_pp")


def _ratios(frame: pd.DataFrame, problems: Problems) -> pd.DataFrame:
    return frame.assign(ratio=above_zero(frame["ratio"], "ratios", problems))


TRIALS = task_trials(
    "ratios",
    "ratio",
    marks=JUDGED,
    numeric=JUDGED,
    columns=JUDGED,
    needed=JUDGED,
    levels=JUDGED[1:],
    derive=_ratios,
)
