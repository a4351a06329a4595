"""Declare ratio judgements."""

from __future__ import annotations

from slipscale.analysis.tasks.declared.flat_table import flat_under
from slipscale.analysis.tasks.declared.one_statistic import of_each, of_one_statistic
from slipscale.analysis.tasks.declared.session_tables import logarithms, mean_by_session
from slipscale.analysis.tasks.ratios import figures, section, sentences
from slipscale.analysis.tasks.ratios.reading import TRIALS
from slipscale.analysis.tasks.ratios.statistics import RATIOS

ANALYSIS = of_one_statistic(
    "ratios",
    TRIALS,
    RATIOS,
    question="How many times as {q.adjective} as a standard is each {q.stimulus}?",
    what="ratio judgement",
    title="Ratio judgements",
    answers=lambda found, level, q: [sentences.ratio_answer(task, level, q) for task in found],
    sentences=sentences.ratio_sentences,
    heading="Ratio judgements",
    blocks=of_each(section.blocks),
    figures=lambda found, trials, q: {
        f"ratios_{each.name}": figures.ratios(each, trials[trials["task"] == each.task], q)
        for each in found
    },
    table=lambda found: flat_under(
        [
            ({"task": task.task, "standard_um_pp": task.standard_um_pp}, each)
            for task in found
            for each in task.surfaces
        ]
    ),
    session_tables=mean_by_session(
        TRIALS, "mean ratio", "natural logarithm", lambda rows: logarithms(rows["ratio"])
    ),
)
