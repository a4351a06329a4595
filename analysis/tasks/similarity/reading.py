"""Read dissimilarities from ratings of pairs or from sorted items.

Items (names or levels) are compared as text. In sorting tasks, the dissimilarity of two items is 1
if their final groups differ, and 0 if they are the same.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import pandas as pd

from slipscale.analysis.reading.delimited import Problems, Source
from slipscale.analysis.reading.labelled_tasks import Entries, header_of
from slipscale.analysis.reading.surface_labels import plain
from slipscale.analysis.reading.task_tables import COMMON, task_trials

ITEMS, RATED, SORTED = ("first", "second"), "dissimilarity", "sorted"


def _pairs(frame: pd.DataFrame, problems: Problems) -> pd.DataFrame:
    unnamed = (frame["first"] == "") | (frame["second"] == "")
    if unnamed.any():
        problems.add(
            f"{int(unnamed.sum())} dissimilarities have no first or second item and are left out"
        )
    named = {name: frame[name].map(plain) for name in ITEMS}
    return frame.assign(**named, **{RATED: frame[RATED].mask(unnamed)}).assign(sorted=False)


def _separated(frame: pd.DataFrame, _problems: Problems) -> pd.DataFrame:
    """Convert sorted items to pairs: 1 if the final groups of two items differ, otherwise 0."""
    rows = []
    run = [name for name in COMMON if name not in ("trial", "catch")]
    answered = frame[frame["group"].notna() & (frame["item"] != "")].sort_values("trial")
    for whose, own in answered.groupby(run, sort=True, dropna=False):
        last = own.groupby(own["item"].map(plain), sort=False)["group"].last().to_dict()
        rows += [
            (*whose, number, False, one, other, float(last[one] != last[other]), True)
            for number, (one, other) in enumerate(combinations(last, 2), start=1)
        ]
    return pd.DataFrame(rows, columns=[*run, "trial", "catch", *ITEMS, RATED, SORTED])


_COLUMNS = (*ITEMS, RATED, SORTED)
_RATINGS = task_trials(
    "dissimilarities",
    "dissimilarity rating",
    marks=(*ITEMS, RATED),
    numeric=(RATED,),
    words=ITEMS,
    columns=_COLUMNS,
    needed=(RATED,),
    derive=_pairs,
)
_SORTING = task_trials(
    "dissimilarities",
    "dissimilarity rating",
    marks=("item", "group"),
    numeric=("group",),
    words=("item",),
    columns=_COLUMNS,
    needed=(RATED,),
    derive=_separated,
)


def _read(
    entries: Entries, folder: Path, problems: Problems, counts: dict[str, int]
) -> tuple[pd.DataFrame, list[Source]]:
    frames, sources = [], []
    for kind in (_RATINGS, _SORTING):
        own = [entry for entry in entries if kind.belongs(header_of(entry[0]))]
        frame, read = kind.read(own, folder, problems, counts)
        frames += [frame] if len(frame) else []
        sources += read
    return pd.concat(frames, ignore_index=True) if frames else _RATINGS.empty(), sources


TRIALS = replace(
    _RATINGS,
    belongs=lambda header: _RATINGS.belongs(header) or _SORTING.belongs(header),
    read=_read,
)
