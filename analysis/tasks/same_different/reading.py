"""Read same–different trials: two surface names, and whether they were judged different."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.answer_codes import FALSE, TRUE
from slipscale.analysis.reading.surface_labels import plain
from slipscale.analysis.reading.task_tables import task_trials

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.reading.delimited import Problems

SURFACES = ("first", "second")
CODES = dict.fromkeys(TRUE, 1.0) | dict.fromkeys(FALSE, 0.0)


def _coded(frame: pd.DataFrame, _problems: Problems) -> pd.DataFrame:
    named = {name: frame[name].map(plain) for name in SURFACES}
    return frame.assign(**named).assign(
        different=frame["response"].str.strip().str.lower().map(CODES)
    )


TRIALS = task_trials(
    "same_different",
    "same–different trial",
    marks=(*SURFACES, "response"),
    numeric=(),
    words=(*SURFACES, "response"),
    columns=(*SURFACES, "different"),
    needed=("different",),
    derive=_coded,
)
