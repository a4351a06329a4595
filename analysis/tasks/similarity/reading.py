"""Read dissimilarity ratings of pairs. Items (names or levels) are compared as text."""

from __future__ import annotations

import pandas as pd

from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.surface_labels import plain
from slipscale.analysis.reading.task_tables import task_trials

ITEMS, RATED = ("first", "second"), "dissimilarity"


def _pairs(frame: pd.DataFrame, problems: Problems) -> pd.DataFrame:
    unnamed = (frame["first"] == "") | (frame["second"] == "")
    if unnamed.any():
        problems.add(
            f"{int(unnamed.sum())} dissimilarities have no first or second item and are left out"
        )
    named = {name: frame[name].map(plain) for name in ITEMS}
    return frame.assign(**named, **{RATED: frame[RATED].mask(unnamed)})


TRIALS = task_trials(
    "dissimilarities",
    "dissimilarity rating",
    marks=(*ITEMS, RATED),
    numeric=(RATED,),
    words=ITEMS,
    columns=(*ITEMS, RATED),
    needed=(RATED,),
    derive=_pairs,
)
