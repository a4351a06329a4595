"""Trials of the visual analogue scale, of ratio judgements and of production, from a data set."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.reading.cleaning import TRUE, labels, numbers
from slipscale.analysis.reading.labelled_tasks import add_counts, read_main_trials
from slipscale.analysis.reading.quantity import AMPLITUDE_DECIMALS
from slipscale.analysis.reading.trial_tables import IDENTITY
from slipscale.experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    import re
    from collections.abc import Sequence
    from pathlib import Path

    from slipscale.analysis.reading.delimited import Problems, Source

    Entries = Sequence[tuple[Path, re.Match[str]]]

#: Columns that make a table one of ratings on a line, of ratios, or of productions.
RATED = ("rating", "amplitude_um_pp", "cursor_start")
JUDGED = ("ratio", "comparison_um_pp", "standard_um_pp")
PRODUCED = ("produced_um_pp", "number", "modulus", "standard_um_pp")
LENGTH = 100.0  # of the line

COMMON = (*IDENTITY, "task", "trial", "catch")
RATINGS = (*COMMON, "surface", "resolution", *RATED)
RATIOS = (*COMMON, *JUDGED)
PRODUCTIONS = (*COMMON, "began", "bound", *PRODUCED)


def empty(columns: tuple[str, ...]) -> pd.DataFrame:
    """Return a table of these columns, without a row."""
    return pd.DataFrame({name: pd.Series(dtype=object) for name in columns})


def read_ratings(
    entries: Entries, folder: Path, problems: Problems, counts: dict[str, int]
) -> tuple[pd.DataFrame, list[Source]]:
    """Return the answered main trials on a line.

    Returns
    -------
    DataFrame, list of Source
        Columns `RATINGS`: ``surface`` is the texture's name, or the amplitude (µm peak to peak);
        a texture has no ``amplitude_um_pp``. Catch trials are marked.
    """
    if not entries:
        return empty(RATINGS), []
    frame, sources = _main_trials(
        entries,
        folder,
        kind="rating",
        required=RATED,
        optional=("resolution",),
        words=("texture",),
        problems=problems,
        counts=counts,
    )
    beyond = frame["rating"] > LENGTH
    if beyond.any():
        problems.add(
            f"{int(beyond.sum())} ratings are above {LENGTH:g}, the right end of the line; they "
            "are left out"
        )
    frame["rating"] = frame["rating"].mask(beyond)
    frame["amplitude_um_pp"] = frame["amplitude_um_pp"].round(AMPLITUDE_DECIMALS)
    texture = labels(frame, "texture", "").astype(str)
    plain = frame["amplitude_um_pp"].map("{:g}".format)
    frame["surface"] = texture.where(texture != "", plain)
    frame["amplitude_um_pp"] = frame["amplitude_um_pp"].where(texture == "")
    return _answered(frame, RATINGS, "rating", ("rating",), counts), sources


def read_ratios(
    entries: Entries, folder: Path, problems: Problems, counts: dict[str, int]
) -> tuple[pd.DataFrame, list[Source]]:
    """Return the answered main trials of ratio judgements: columns `RATIOS`, ratios above 0."""
    if not entries:
        return empty(RATIOS), []
    frame, sources = _main_trials(
        entries, folder, kind="ratio", required=JUDGED, problems=problems, counts=counts
    )
    for name in JUDGED[1:]:
        frame[name] = frame[name].round(AMPLITUDE_DECIMALS)
    frame["ratio"] = _above_zero(frame["ratio"], "ratios", problems)
    return _answered(frame, RATIOS, "ratio", JUDGED, counts), sources


def read_productions(
    entries: Entries, folder: Path, problems: Problems, counts: dict[str, int]
) -> tuple[pd.DataFrame, list[Source]]:
    """Return the answered main trials of production: columns `PRODUCTIONS`, all above 0."""
    if not entries:
        return empty(PRODUCTIONS), []
    frame, sources = _main_trials(
        entries,
        folder,
        kind="production",
        required=PRODUCED,
        words=("began", "bound"),
        problems=problems,
        counts=counts,
    )
    for name in ("began", "bound"):
        frame[name] = labels(frame, name, "").astype(str)
    for name, what in (("produced_um_pp", "productions"), ("number", "numbers to be produced")):
        frame[name] = _above_zero(frame[name], what, problems)
    return _answered(frame, PRODUCTIONS, "production", PRODUCED, counts), sources


def _main_trials(
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


def _above_zero(values: pd.Series[float], what: str, problems: Problems) -> pd.Series[float]:
    """Return values without those of 0, which have no logarithm, and say how many there were."""
    zero = values == 0
    if zero.any():
        problems.add(f"{int(zero.sum())} {what} are 0, which is no ratio; they are left out")
    return values.mask(zero)


def _answered(
    frame: pd.DataFrame,
    columns: tuple[str, ...],
    kind: str,
    needed: tuple[str, ...],
    counts: dict[str, int],
) -> pd.DataFrame:
    answered = frame[list(needed)].notna().all(axis=1)
    kept = frame[answered]
    add_counts(counts, kind, unanswered=(~answered).sum(), analysed=len(kept))
    people = pd.Categorical(kept[PARTICIPANT].astype(str))
    return kept.assign(**{PARTICIPANT: people})[list(columns)].reset_index(drop=True)
