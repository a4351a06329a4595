"""Declare sessions as a factor."""

from __future__ import annotations

from slipscale.analysis.tasks.kind import TaskAnalysis
from slipscale.analysis.tasks.sessions import section, sentences
from slipscale.analysis.tasks.sessions.statistics import SESSIONS

ANALYSIS = TaskAnalysis(
    name="sessions",
    statistics=(SESSIONS,),
    sentences=lambda analysis: {
        "Sessions": sentences.session_sentences(
            analysis.inference[SESSIONS],
            analysis.dataset.choices.confidence,
            analysis.dataset.quantity,
        )
    },
    sections=(section.sessions,),
)
