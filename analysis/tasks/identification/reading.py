"""Read identification trials: the presented surface and the named surface, as text."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.surface_labels import plain
from slipscale.analysis.reading.task_tables import task_trials

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.reading.delimited import Problems

ITEMS = ("presented", "named")


def _known(frame: pd.DataFrame, _problems: Problems) -> pd.DataFrame:
    """Return trials with the column ``right``; NaN without a name or an answer."""
    whole = (frame["presented"] != "") & (frame["named"] != "")
    right = (frame["presented"] == frame["named"]).astype(float)
    return frame.assign(**{name: frame[name].map(plain) for name in ITEMS}).assign(
        right=right.where(whole)
    )


TRIALS = task_trials(
    "identifications",
    "identification",
    marks=ITEMS,
    numeric=(),
    words=ITEMS,
    columns=(*ITEMS, "right"),
    needed=("right",),
    derive=_known,
)
