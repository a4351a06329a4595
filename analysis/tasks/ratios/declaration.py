"""Ratio judgements, declared."""

from __future__ import annotations

from slipscale.analysis.tasks.declaring import of_one_statistic
from slipscale.analysis.tasks.ratios import figures, section, sentences, table
from slipscale.analysis.tasks.ratios.reading import TRIALS
from slipscale.analysis.tasks.ratios.statistics import RATIOS
from slipscale.analysis.tasks.session_tables import logarithms, mean_by_session

ANALYSIS = of_one_statistic(
    "ratios",
    TRIALS,
    RATIOS,
    question="How many times as slippery as a standard is each surface?",
    what="ratio judgement",
    title="Ratio judgements",
    answers=lambda found, level: [sentences.ratio_answer(task, level) for task in found],
    sentences=sentences.ratio_sentences,
    section=section.ratios,
    figures=lambda found, trials: {
        f"ratios_{each.name}": figures.ratios(each, trials[trials["task"] == each.task])
        for each in found
    },
    table=table.ratio_table,
    session_tables=mean_by_session(
        TRIALS, "mean ratio", "natural logarithm", lambda rows: logarithms(rows["ratio"])
    ),
)
