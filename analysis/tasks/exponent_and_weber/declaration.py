"""Declare the comparison between exponent and Weber fraction in the same participants."""

from __future__ import annotations

from slipscale.analysis.tasks.exponent_and_weber import figures, section, sentences
from slipscale.analysis.tasks.exponent_and_weber.statistics import EXPONENT_AND_WEBER
from slipscale.analysis.tasks.kind import TaskAnalysis

ANALYSIS = TaskAnalysis(
    name="exponent_and_weber",
    statistics=(EXPONENT_AND_WEBER,),
    sentences=lambda analysis: {
        "Exponent and Weber fraction": sentences.sentences(
            analysis.inference.found(EXPONENT_AND_WEBER) or (),
            analysis.dataset.choices.confidence,
            analysis.dataset.quantity,
        )
    },
    sections=(section.exponent_and_weber,),
    figures=lambda analysis: {
        f"exponent_and_weber_{one.task}": figures.exponent_and_weber(one)
        for one in analysis.inference.found(EXPONENT_AND_WEBER) or ()
    },
)
