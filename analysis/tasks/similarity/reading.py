"""Read trials of dissimilarity ratings: two items, ``first`` and ``second``, and a number.

Items are names or levels; they are compared as text.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.task_tables import task_trials

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.reading.delimited import Problems

ITEMS, RATED = ("first", "second"), "dissimilarity"


def _pairs(frame: pd.DataFrame, problems: Problems) -> pd.DataFrame:
    unnamed = (frame["first"] == "") | (frame["second"] == "")
    if unnamed.any():
        problems.add(f"{int(unnamed.sum())} dissimilarities have no first or second item; left out")
    return frame.assign(**{RATED: frame[RATED].mask(unnamed)})


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
