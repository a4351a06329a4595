"""Read the steps of a descending difference task."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from slipscale.analysis.reading.cleaning import clean_differences, empty_differences
from slipscale.analysis.reading.delimited import Problems, Source
from slipscale.analysis.reading.labelled_tasks import Entries, TaskTrials
from slipscale.analysis.reading.protocol_tables import read_protocol
from slipscale.analysis.reading.trial_tables import DIFFERENCE, STEP_AMPLITUDES, set_aside


def read_steps(
    entries: Entries, folder: Path, problems: Problems, _counts: dict[str, int]
) -> tuple[pd.DataFrame, list[Source]]:
    """Return all steps, with parsed numbers and answers."""
    if not entries:
        return empty_differences(), []
    frame, sources = read_protocol(DIFFERENCE, entries, folder, problems)
    return clean_differences(frame, sources, problems), sources


def divide(
    frame: pd.DataFrame, _problems: Problems, counts: dict[str, int]
) -> dict[str, pd.DataFrame]:
    """Return the answered steps, without practice."""
    return {"differences": _keep_steps(frame, counts)}


def _keep_steps(frame: pd.DataFrame, counts: dict[str, int]) -> pd.DataFrame:
    counts["difference_rows"] = len(frame)
    if not len(frame):
        return frame
    practice, voided = set_aside(frame)
    counts["difference_practice"] = int(practice.sum())
    counts["difference_voided"] = int(voided.sum())
    kept = frame[~practice & ~voided]
    answered = kept[["difference_felt", *STEP_AMPLITUDES]].notna().all(axis=1)
    counts["difference_unanswered"] = int((~answered).sum())
    kept = kept[answered].reset_index(drop=True)
    counts["difference_analysed"] = len(kept)
    return kept


TRIALS = TaskTrials(
    name="differences",
    counted="difference",
    title="descending difference",
    label=DIFFERENCE.task,
    belongs=lambda header: header.issuperset({*DIFFERENCE.required, "series", "step"}),
    read=read_steps,
    divide=divide,
    empty=empty_differences,
    reasons={
        "difference_practice": "practice trials",
        "difference_voided": "voided trials",
        "difference_unanswered": "trials without a usable answer",
    },
)
