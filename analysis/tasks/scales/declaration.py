"""Declare scales from paired comparison and triads."""

from __future__ import annotations

from slipscale.analysis.statistics.not_computed import computed
from slipscale.analysis.tasks.declared.one_statistic import of_each, of_one_statistic
from slipscale.analysis.tasks.scales import figures, section, sentences, table
from slipscale.analysis.tasks.scales.reading import TRIALS
from slipscale.analysis.tasks.scales.statistics import SCALES

ANALYSIS = of_one_statistic(
    "scales",
    TRIALS,
    SCALES,
    question="How do the {q.stimuli} lie on one scale of {q.judged}?",
    what="paired comparison",
    title="Paired comparison",
    answers=lambda found, _, q: [sentences.scale_answer(task, q) for task in found],
    sentences=lambda found, _, q: sentences.scale_sentences(found, q),
    heading="Scales of {q.judged}",
    blocks=of_each(section.blocks),
    figures=lambda found, _, q: {
        f"scale_{each.task}": figures.scale(each, q)
        for each in found
        if any(map(computed, (each.bradley_terry, each.differences)))
    },
    table=table.scale_table,
)
