"""Read matching trials from a data set, with amplitudes peak to peak.

``felt_again`` is the number of times the reference was repeated; NaN in tables without that
column.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.task_tables import task_trials
from slipscale.experiments.dataset.schema import INTERVAL

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.reading.delimited import Problems

REFERENCE = f"{INTERVAL}1_amplitude_um_pp"


def _matches(frame: pd.DataFrame, _problems: Problems) -> pd.DataFrame:
    return frame.assign(reference_um_pp=frame[REFERENCE])


TRIALS = task_trials(
    "matches",
    "matching",
    marks=("matched_um_pp", "direction"),
    required=(REFERENCE,),
    numeric=(REFERENCE, "matched_um_pp", "felt_again"),
    words=("direction",),
    columns=("direction", "reference_um_pp", "matched_um_pp", "felt_again"),
    needed=("reference_um_pp", "matched_um_pp"),
    derive=_matches,
)
