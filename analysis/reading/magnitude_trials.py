"""Trials of the visual analogue scale, of ratio judgements and of production: what they share."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.reading.answer_codes import TRUE
from slipscale.analysis.reading.cleaning import labels, numbers
from slipscale.analysis.reading.labelled_tasks import add_counts, read_main_trials, with_people
from slipscale.analysis.reading.trial_tables import IDENTITY

if TYPE_CHECKING:
    import re
    from collections.abc import Sequence
    from pathlib import Path

    from slipscale.analysis.reading.delimited import Problems, Source

    Entries = Sequence[tuple[Path, re.Match[str]]]


COMMON = (*IDENTITY, "task", "trial", "catch")


def empty(columns: tuple[str, ...]) -> pd.DataFrame:
    """Return a table of these columns, without a row."""
    return pd.DataFrame({name: pd.Series(dtype=object) for name in columns})


def main_trials(
    entries: Entries,
    folder: Path,
    *,
    kind: str,
    required: tuple[str, ...],
    optional: tuple[str, ...] = (),
    words: tuple[str, ...] = (),
    problems: Problems,
    counts: dict[str, int],
) -> tuple[pd.DataFrame, list[Source]]:
    """Return main trials with their numbers read, and whether they are catch trials."""
    frame, sources = read_main_trials(
        entries,
        folder,
        kind=kind,
        required=required,
        columns=("trial", "catch", *required, *optional, *words),
        problems=problems,
        counts=counts,
    )
    frame["catch"] = labels(frame, "catch", "false").astype(str).str.lower().isin(TRUE)
    for name in ("trial", *required, *optional):
        frame[name] = (
            numbers(frame, name, sources, problems, minimum=0.0) if name in frame else np.nan
        )
    return frame, sources


def above_zero(values: pd.Series[float], what: str, problems: Problems) -> pd.Series[float]:
    """Return values without those of 0, which have no logarithm, and say how many there were."""
    zero = values == 0
    if zero.any():
        problems.add(f"{int(zero.sum())} {what} are 0, which is no ratio; they are left out")
    return values.mask(zero)


def answered(
    frame: pd.DataFrame,
    columns: tuple[str, ...],
    kind: str,
    needed: tuple[str, ...],
    counts: dict[str, int],
) -> pd.DataFrame:
    """Return the trials that hold all that is needed, and count the others."""
    answered = frame[list(needed)].notna().all(axis=1)
    kept = frame[answered]
    add_counts(counts, kind, unanswered=(~answered).sum(), analysed=len(kept))
    return with_people(kept, columns)
