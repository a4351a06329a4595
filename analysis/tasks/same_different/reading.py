"""Read same–different trials: two surface names, and whether they were judged different."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.answer_codes import own_answers
from slipscale.analysis.reading.surface_labels import plain
from slipscale.analysis.reading.task_tables import task_trials

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.reading.delimited import Problems

SURFACES = ("first", "second")


def _coded(frame: pd.DataFrame, _problems: Problems) -> pd.DataFrame:
    named = {name: frame[name].map(plain) for name in SURFACES}
    return frame.assign(**named, different=own_answers(frame["response"]))


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
