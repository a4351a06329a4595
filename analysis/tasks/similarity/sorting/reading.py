"""Read sorted items as dissimilarities of pairs: 1 if their final groups differ, otherwise 0."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import pandas as pd

from slipscale.analysis.reading.delimited import Problems, Source
from slipscale.analysis.reading.labelled_tasks import Entries, add_counts
from slipscale.analysis.reading.surface_labels import plain
from slipscale.analysis.reading.task_tables import BEFORE_CONDITION, COMMON, task_trials
from slipscale.analysis.reading.trial_tables import factor_columns
from slipscale.analysis.tasks.similarity.reading import ITEMS, RATED

TITLE = "free sorting"
#: Columns that identify a run.
RUN = [name for name in COMMON if name not in ("trial", "catch")]


def separated(frame: pd.DataFrame, _problems: Problems) -> pd.DataFrame:
    """Convert sorted items to pairs. The last group of an item counts."""
    keys = [*RUN, *factor_columns(frame)]
    keys += [BEFORE_CONDITION] if BEFORE_CONDITION in frame else []
    rows = []
    answered = frame[frame["group"].notna() & (frame["item"] != "")].sort_values("trial")
    for whose, own in answered.groupby(keys, sort=True, dropna=False):
        last = own.groupby(own["item"].map(plain), sort=False)["group"].last().to_dict()
        rows += [
            (*whose, number, False, one, other, float(last[one] != last[other]))
            for number, (one, other) in enumerate(combinations(last, 2), start=1)
        ]
    return pd.DataFrame(rows, columns=[*keys, "trial", "catch", *ITEMS, RATED])


def sorted_items(pairs: pd.DataFrame) -> int:
    """Return the number of items with a final group, over all runs."""
    both = [pairs[RUN].assign(item=pairs[name]) for name in ITEMS]
    return len(pd.concat(both).drop_duplicates())


_PAIRS = task_trials(
    "sorting",
    TITLE,
    marks=("item", "group"),
    numeric=("group",),
    words=("item",),
    columns=(*ITEMS, RATED),
    needed=(RATED,),
    derive=separated,
)


def _read(
    entries: Entries, folder: Path, problems: Problems, counts: dict[str, int]
) -> tuple[pd.DataFrame, list[Source]]:
    """Read pairs, and count sorted items instead of pairs."""
    frame, sources = _PAIRS.read(entries, folder, problems, counts)
    if sources:
        rows, practice, voided = (
            counts[f"{TITLE}_{name}"] for name in ("rows", "practice", "voided")
        )
        counts[f"{TITLE}_analysed"] = sorted_items(frame)
        again = rows - practice - voided - counts[f"{TITLE}_analysed"]
        add_counts(counts, TITLE, replaced=again)
    return frame, sources


TRIALS = replace(
    _PAIRS,
    read=_read,
    reasons={
        f"{TITLE}_practice": "practice trials",
        f"{TITLE}_voided": "voided trials",
        f"{TITLE}_replaced": "trials without a group, or sorted again in a later round",
    },
)
