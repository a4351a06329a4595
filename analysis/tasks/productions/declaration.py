"""Magnitude production, declared."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.tasks.declaring import run_trials, tables_of
from slipscale.analysis.tasks.kind import TaskAnalysis
from slipscale.analysis.tasks.productions import figures, section, sentences, table
from slipscale.analysis.tasks.productions.reading import TRIALS
from slipscale.analysis.tasks.productions.statistics import PRODUCTIONS
from slipscale.analysis.tasks.session_tables import logarithms, mean_by_session

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.figure import Figure

    from slipscale.analysis.result import Analysis


def _answers(analysis: Analysis) -> list[str]:
    level = analysis.dataset.choices.confidence
    found = analysis.inference.found(PRODUCTIONS) or ()
    return [text for task in found for text in sentences.production_answers(task, level)]


def _sentences(analysis: Analysis) -> Mapping[str, list[str]]:
    found, level = analysis.inference[PRODUCTIONS], analysis.dataset.choices.confidence
    return {"Magnitude production": sentences.production_sentences(found, level)}


def _figures(analysis: Analysis) -> Mapping[str, Figure]:
    trials = analysis.dataset.of(TRIALS)
    return {
        f"productions_{each.task}": figures.productions(each, trials[trials["task"] == each.task])
        for each in analysis.inference.found(PRODUCTIONS) or ()
    }


ANALYSIS = TaskAnalysis(
    name="productions",
    trials=TRIALS,
    statistics=(PRODUCTIONS,),
    questions=lambda analysis: (
        ["Which amplitudes are as slippery as given numbers?"]
        if analysis.inference.found(PRODUCTIONS)
        else []
    ),
    design=run_trials(TRIALS, "magnitude production"),
    answers=_answers,
    sentences=_sentences,
    sections=(section.productions,),
    figures=_figures,
    tables=tables_of("productions", PRODUCTIONS, table.production_table),
    session_tables=mean_by_session(
        TRIALS,
        "mean produced amplitude",
        "natural logarithm, µm p-p",
        lambda rows: logarithms(rows["produced_um_pp"]),
    ),
)
