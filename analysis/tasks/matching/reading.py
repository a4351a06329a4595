"""Trials of matching, from a data set."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.reading.answer_codes import TRUE
from slipscale.analysis.reading.cleaning import labels, numbers
from slipscale.analysis.reading.labelled_tasks import (
    TaskTrials,
    add_counts,
    read_main_trials,
    with_people,
)
from slipscale.analysis.reading.trial_tables import IDENTITY
from slipscale.experiments.dataset.schema import INTERVAL

if TYPE_CHECKING:
    import re
    from collections.abc import Sequence
    from pathlib import Path

    from slipscale.analysis.reading.delimited import Problems, Source

    Entries = Sequence[tuple[Path, re.Match[str]]]


MATCHED = ("matched_um_pp", "direction")


REFERENCE = f"{INTERVAL}1_amplitude_um_pp"


MATCHES = (
    *(*IDENTITY, "task", "trial", "catch", "direction"),
    *("reference_um_pp", "matched_um_pp", "felt_again"),
)


def empty_matches() -> pd.DataFrame:
    """Return the columns of `read_matches`, without a row."""
    return pd.DataFrame({name: pd.Series(dtype=object) for name in MATCHES})


def read_matches(
    entries: Entries, folder: Path, problems: Problems, counts: dict[str, int]
) -> tuple[pd.DataFrame, list[Source]]:
    """Return the answered main trials of matching: columns `MATCHES`, amplitudes peak to peak.

    ``felt_again`` is how often the reference was felt again, NaN in tables that do not tell.
    """
    if not entries:
        return empty_matches(), []
    frame, sources = read_main_trials(
        entries,
        folder,
        kind="matching",
        required=(*MATCHED, REFERENCE),
        columns=("trial", "catch", "felt_again", *MATCHED, REFERENCE),
        problems=problems,
        counts=counts,
    )
    frame["direction"] = labels(frame, "direction", "").astype(str)
    frame["catch"] = labels(frame, "catch", "false").astype(str).str.lower().isin(TRUE)
    for name in ("trial", "felt_again"):
        frame[name] = numbers(frame, name, sources, problems) if name in frame else np.nan
    frame["reference_um_pp"] = numbers(frame, REFERENCE, sources, problems, minimum=0.0)
    frame["matched_um_pp"] = numbers(frame, "matched_um_pp", sources, problems, minimum=0.0)
    answered = frame[["reference_um_pp", "matched_um_pp"]].notna().all(axis=1)
    kept = frame[answered]
    add_counts(counts, "matching", unanswered=(~answered).sum(), analysed=len(kept))
    return with_people(kept, MATCHES), sources


TRIALS = TaskTrials(
    name="matches",
    counted="matching",
    title="matching",
    belongs=lambda header: header.issuperset(MATCHED),
    read=read_matches,
    empty=empty_matches,
)
