"""Ratio judgements, declared."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.tasks.declaring import run_trials, tables_of
from slipscale.analysis.tasks.kind import TaskAnalysis
from slipscale.analysis.tasks.ratios import figures, section, sentences, table
from slipscale.analysis.tasks.ratios.reading import TRIALS
from slipscale.analysis.tasks.ratios.statistics import RATIOS
from slipscale.analysis.tasks.session_tables import logarithms, mean_by_session

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.figure import Figure

    from slipscale.analysis.result import Analysis


def _answers(analysis: Analysis) -> list[str]:
    level = analysis.dataset.choices.confidence
    found = analysis.inference.found(RATIOS) or ()
    return [sentences.ratio_answer(task, level) for task in found]


def _sentences(analysis: Analysis) -> Mapping[str, list[str]]:
    found, level = analysis.inference[RATIOS], analysis.dataset.choices.confidence
    return {"Ratio judgements": sentences.ratio_sentences(found, level)}


def _figures(analysis: Analysis) -> Mapping[str, Figure]:
    trials = analysis.dataset.of(TRIALS)
    return {
        f"ratios_{each.name}": figures.ratios(each, trials[trials["task"] == each.task])
        for each in analysis.inference.found(RATIOS) or ()
    }


ANALYSIS = TaskAnalysis(
    name="ratios",
    trials=TRIALS,
    statistics=(RATIOS,),
    questions=lambda analysis: (
        ["How many times as slippery as a standard is each surface?"]
        if analysis.inference.found(RATIOS)
        else []
    ),
    design=run_trials(TRIALS, "ratio judgement"),
    answers=_answers,
    sentences=_sentences,
    sections=(section.ratios,),
    figures=_figures,
    tables=tables_of("ratios", RATIOS, table.ratio_table),
    session_tables=mean_by_session(
        TRIALS, "mean ratio", "natural logarithm", lambda rows: logarithms(rows["ratio"])
    ),
)
