"""Declare the comparison of groups of participants."""

from __future__ import annotations

from slipscale.analysis.tasks.groups import section, sentences
from slipscale.analysis.tasks.groups.statistics import GROUPS
from slipscale.analysis.tasks.kind import TaskAnalysis

ANALYSIS = TaskAnalysis(
    name="groups",
    statistics=(GROUPS,),
    answers=lambda analysis: sentences.answers(
        analysis.inference[GROUPS], analysis.dataset.choices.confidence
    ),
    sentences=lambda analysis: {
        "Groups": sentences.group_sentences(
            analysis.inference[GROUPS],
            analysis.dataset.choices.confidence,
            analysis.dataset.quantity,
        )
    },
    sections=(section.groups,),
)
