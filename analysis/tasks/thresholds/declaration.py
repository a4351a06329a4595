"""Thresholds from forced choice, declared."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.tasks.declaring import run_trials, tables_of
from slipscale.analysis.tasks.kind import TaskAnalysis
from slipscale.analysis.tasks.thresholds import figures, section, sentences, table
from slipscale.analysis.tasks.thresholds.reading import TRIALS
from slipscale.analysis.tasks.thresholds.session_tables import session_tables
from slipscale.analysis.tasks.thresholds.statistics import THRESHOLDS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.figure import Figure

    from slipscale.analysis.result import Analysis


def _answers(analysis: Analysis) -> list[str]:
    level = analysis.dataset.choices.confidence
    found = analysis.inference.found(THRESHOLDS) or ()
    return [sentences.answer(task, level) for task in found]


def _sentences(analysis: Analysis) -> Mapping[str, list[str]]:
    found, level = analysis.inference[THRESHOLDS], analysis.dataset.choices.confidence
    return {"Thresholds": sentences.sentences(found, level)}


def _figures(analysis: Analysis) -> Mapping[str, Figure]:
    trials = analysis.dataset.of(TRIALS)
    drawn = {}
    for task in analysis.inference.found(THRESHOLDS) or ():
        own = trials[trials["task"] == task.task]
        drawn[f"thresholds_{task.task}"] = figures.functions(task, own)
        if own["track"].notna().any():
            drawn[f"tracks_{task.task}"] = figures.tracks(task, own)
    return drawn


ANALYSIS = TaskAnalysis(
    name="thresholds",
    trials=TRIALS,
    statistics=(THRESHOLDS,),
    questions=lambda analysis: (
        ["How small an amplitude, or a change of it, is felt?"]
        if analysis.inference.found(THRESHOLDS)
        else []
    ),
    design=run_trials(TRIALS, "forced choice"),
    answers=_answers,
    sentences=_sentences,
    sections=(section.thresholds,),
    figures=_figures,
    tables=tables_of("thresholds", THRESHOLDS, table.threshold_table),
    session_tables=session_tables,
)
