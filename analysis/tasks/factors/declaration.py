"""Declare factors that are crossed with the levels."""

from __future__ import annotations

from slipscale.analysis.tasks.factors import section, sentences
from slipscale.analysis.tasks.factors.statistics import FACTORS
from slipscale.analysis.tasks.kind import Analysis, TaskAnalysis


def _sentences(analysis: Analysis) -> list[str]:
    data = analysis.dataset
    return sentences.factor_sentences(
        analysis.inference[FACTORS], data.choices.confidence, data.quantity
    )


ANALYSIS = TaskAnalysis(
    name="factors",
    statistics=(FACTORS,),
    answers=_sentences,
    sentences=lambda analysis: {"Factors": _sentences(analysis)},
    sections=(section.factors,),
)
