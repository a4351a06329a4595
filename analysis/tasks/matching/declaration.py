"""Matching, declared."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.tasks.declaring import run_trials, tables_of
from slipscale.analysis.tasks.kind import TaskAnalysis
from slipscale.analysis.tasks.matching import figures, section, sentences, table
from slipscale.analysis.tasks.matching.reading import TRIALS
from slipscale.analysis.tasks.matching.statistics import MATCHING
from slipscale.analysis.tasks.session_tables import mean_by_session

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.figure import Figure

    from slipscale.analysis.result import Analysis


def _answers(analysis: Analysis) -> list[str]:
    level = analysis.dataset.choices.confidence
    found = analysis.inference.found(MATCHING) or ()
    return sentences.matching_sentences(tuple(found), level)


def _sentences(analysis: Analysis) -> Mapping[str, list[str]]:
    found, level = analysis.inference[MATCHING], analysis.dataset.choices.confidence
    return {"Matching": sentences.matching_sentences(found, level)}


def _figures(analysis: Analysis) -> Mapping[str, Figure]:
    trials = analysis.dataset.of(TRIALS)
    found = analysis.inference.found(MATCHING) or ()
    return {
        f"matching_{task}": figures.matches(
            [each for each in found if each.task == task], trials[trials["task"] == task]
        )
        for task in sorted({each.task for each in found})
    }


ANALYSIS = TaskAnalysis(
    name="matching",
    trials=TRIALS,
    statistics=(MATCHING,),
    questions=lambda analysis: (
        ["Which amplitude feels the same as a reference?"]
        if analysis.inference.found(MATCHING)
        else []
    ),
    design=run_trials(TRIALS, "matching"),
    answers=_answers,
    sentences=_sentences,
    sections=(section.matching,),
    figures=_figures,
    tables=tables_of("matching", MATCHING, table.matching_table),
    session_tables=mean_by_session(
        TRIALS,
        "match less reference",
        "µm p-p",
        lambda rows: (rows["matched_um_pp"] - rows["reference_um_pp"]).astype(float),
    ),
)
