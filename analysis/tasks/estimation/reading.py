"""Read trials of magnitude estimation.

Trials of textures are kept separate, because the amplitude recorded for a texture is its maximum
and not the amplitude of a plain surface.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pandas as pd

from slipscale.analysis.preprocessing.log_transform import order_of
from slipscale.analysis.reading.cleaning import clean_estimates, empty_estimates
from slipscale.analysis.reading.delimited import Problems, Source
from slipscale.analysis.reading.labelled_tasks import Entries, TaskTrials, factors_of
from slipscale.analysis.reading.protocol_tables import read_protocol
from slipscale.analysis.reading.trial_tables import ESTIMATION, has_flag, set_aside
from slipscale.experiments.dataset.schema import FAULT, PARTICIPANT, REPRESENTED, TIMED_OUT


def read_estimates(
    entries: Entries, folder: Path, problems: Problems, _counts: dict[str, int]
) -> tuple[pd.DataFrame, list[Source]]:
    """Return all trials of magnitude estimation, with parsed numbers."""
    if not entries:
        return empty_estimates(), []
    factors = factors_of(folder)
    table = replace(ESTIMATION, words=(*ESTIMATION.words, *factors))
    frame, sources = read_protocol(table, entries, folder, problems)
    return clean_estimates(frame, sources, problems, factors=factors), sources


def divide(
    frame: pd.DataFrame, problems: Problems, counts: dict[str, int]
) -> dict[str, pd.DataFrame]:
    """Divide the main trials into three tables.

    The tables are ``answers``, with all trials of plain surfaces; ``estimates``, with those that
    have a usable answer; and ``textures``, with the answered trials of textures.
    """
    main = _keep_main_trials(frame, counts)
    answers, textures = _part_textures(main, counts, problems)
    return {"estimates": _answered(answers, counts), "answers": answers, "textures": textures}


def _keep_main_trials(frame: pd.DataFrame, counts: dict[str, int]) -> pd.DataFrame:
    """Return main trials that were not voided, with the columns ``timed_out`` and ``faulty``."""
    counts["estimation_rows"] = len(frame)
    practice, voided = set_aside(frame)
    counts["practice"], counts["voided"] = int(practice.sum()), int(voided.sum())
    main = frame[~practice & ~voided].reset_index(drop=True)
    main["timed_out"] = has_flag(main, TIMED_OUT)
    main["faulty"] = has_flag(main, FAULT, REPRESENTED)
    counts["timed_out"] = int(main["timed_out"].sum())
    counts["faulty"] = int(main["faulty"].sum())
    return main


def _part_textures(
    main: pd.DataFrame, counts: dict[str, int], problems: Problems
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the trials of plain surfaces, and the answered trials of textures."""
    modulated = main["texture"].astype(str) != ""
    textures = main[modulated & main["estimate"].notna()].reset_index(drop=True)
    # The order is recorded before textures and unanswered trials are removed.
    main = main.join(order_of(main, main["level"].mask(modulated)))
    counts["textures"] = int(modulated.sum())
    if counts["textures"]:
        names = ", ".join(sorted(main.loc[modulated, "texture"].astype(str).unique()))
        problems.add(
            f"{counts['textures']} trials of textures ({names}) are excluded from the amplitude "
            "results, because a texture has no single amplitude. A separate table describes the "
            "estimates of textures."
        )
    return main[~modulated].drop(columns="texture").reset_index(drop=True), textures


def _answered(main: pd.DataFrame, counts: dict[str, int]) -> pd.DataFrame:
    answered = main["estimate"].notna() & main["level"].notna()
    counts["unanswered"] = int((~answered).sum())
    kept = main[answered].reset_index(drop=True)
    kept[PARTICIPANT] = kept[PARTICIPANT].cat.remove_unused_categories()
    counts["analysed"] = len(kept)
    return kept


TRIALS = TaskTrials(
    name="estimates",
    counted="estimation",
    title="magnitude estimation",
    label=ESTIMATION.task,
    belongs=lambda header: header.issuperset({*ESTIMATION.required, "scale_top", "modulus"}),
    read=read_estimates,
    divide=divide,
    empty=empty_estimates,
    reasons={
        "practice": "practice trials",
        "voided": "voided trials",
        "textures": (
            "trials of textures, which are normalised like plain surfaces and reported separately"
        ),
        "unanswered": "trials without a usable answer",
    },
)
