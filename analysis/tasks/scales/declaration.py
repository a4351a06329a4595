"""Scales from paired comparison and triads, declared."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declaring import run_trials, tables_of
from slipscale.analysis.tasks.kind import TaskAnalysis
from slipscale.analysis.tasks.scales import figures, section, sentences, table
from slipscale.analysis.tasks.scales.reading import TRIALS
from slipscale.analysis.tasks.scales.statistics import SCALES

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.figure import Figure

    from slipscale.analysis.result import Analysis


def _answers(analysis: Analysis) -> list[str]:
    found = analysis.inference.found(SCALES) or ()
    return [sentences.scale_answer(task) for task in found]


def _sentences(analysis: Analysis) -> Mapping[str, list[str]]:
    return {"Paired comparison": sentences.scale_sentences(analysis.inference[SCALES])}


def _figures(analysis: Analysis) -> Mapping[str, Figure]:
    return {
        f"scale_{each.task}": figures.scale(each)
        for each in analysis.inference.found(SCALES) or ()
        if not all(isinstance(one, NotComputed) for one in (each.bradley_terry, each.differences))
    }


ANALYSIS = TaskAnalysis(
    name="scales",
    trials=TRIALS,
    statistics=(SCALES,),
    questions=lambda analysis: (
        ["How do the surfaces lie on one scale of slipperiness?"]
        if analysis.inference.found(SCALES)
        else []
    ),
    design=run_trials(TRIALS, "paired comparison"),
    answers=_answers,
    sentences=_sentences,
    sections=(section.scales,),
    figures=_figures,
    tables=tables_of("scales", SCALES, table.scale_table),
)
