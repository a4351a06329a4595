"""Read paired-comparison and triad trials from a data set.

Stimuli are labels; the third is empty for pairs. ``response`` is the number of the chosen interval
or of the larger step.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.surface_labels import plain
from slipscale.analysis.reading.task_tables import task_trials

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.reading.delimited import Problems

STIMULI = ("stimulus1", "stimulus2", "stimulus3")


def _comparisons(frame: pd.DataFrame, _problems: Problems) -> pd.DataFrame:
    return frame.assign(
        response=frame["response"].where(frame["response"].isin([1, 2])),
        **{name: frame[name].map(plain) for name in STIMULI},
    )


TRIALS = task_trials(
    "comparisons",
    "comparison",
    marks=(*STIMULI[:2], "response"),
    numeric=("response",),
    words=STIMULI,
    columns=(*STIMULI, "response"),
    needed=("response",),
    derive=_comparisons,
)
