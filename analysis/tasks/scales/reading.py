"""Trials of paired comparison and of triads, from a data set."""

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
from slipscale.analysis.reading.surface_labels import amplitude_of
from slipscale.analysis.reading.trial_tables import IDENTITY

if TYPE_CHECKING:
    import re
    from collections.abc import Sequence
    from pathlib import Path

    from slipscale.analysis.reading.delimited import Problems, Source

    Entries = Sequence[tuple[Path, re.Match[str]]]

STIMULI = ("stimulus1", "stimulus2", "stimulus3")


#: Columns that make a table one of comparisons, or of matching.
COMPARED = (*STIMULI[:2], "response")


COMPARISONS = (*IDENTITY, "task", "trial", "catch", *STIMULI, "response")


def empty_comparisons() -> pd.DataFrame:
    """Return the columns of `read_comparisons`, without a row."""
    return pd.DataFrame({name: pd.Series(dtype=object) for name in COMPARISONS})


def read_comparisons(
    entries: Entries, folder: Path, problems: Problems, counts: dict[str, int]
) -> tuple[pd.DataFrame, list[Source]]:
    """Return the answered main trials of pairs and triads.

    Returns
    -------
    DataFrame, list of Source
        Columns `COMPARISONS`: stimuli are labels, the third empty in pairs; ``response`` is the
        number of the interval chosen, or of the larger step.
    """
    if not entries:
        return empty_comparisons(), []
    frame, sources = read_main_trials(
        entries,
        folder,
        kind="comparison",
        required=COMPARED,
        columns=("trial", "catch", *STIMULI, "response"),
        problems=problems,
        counts=counts,
    )
    for name in STIMULI:
        frame[name] = labels(frame, name, "").astype(str).map(_plain)
    frame["catch"] = labels(frame, "catch", "false").astype(str).str.lower().isin(TRUE)
    for name in ("trial", "response"):
        frame[name] = numbers(frame, name, sources, problems) if name in frame else np.nan
    answered = frame["response"].isin([1, 2])
    kept = frame[answered]
    add_counts(counts, "comparison", unanswered=(~answered).sum(), analysed=len(kept))
    return with_people(kept, COMPARISONS), sources


def _plain(label: str) -> str:
    """Return an amplitude as every table writes it; other labels as they are.

    >>> _plain("0.50"), _plain("fine")
    ('0.5', 'fine')
    """
    amplitude = amplitude_of(label)
    return label if amplitude is None else f"{amplitude:g}"


TRIALS = TaskTrials(
    name="comparisons",
    counted="comparison",
    title="comparison",
    belongs=lambda header: header.issuperset(COMPARED),
    read=read_comparisons,
    empty=empty_comparisons,
)
