"""Declare matching."""

from __future__ import annotations

from slipscale.analysis.tasks.declared.one_statistic import of_one_statistic
from slipscale.analysis.tasks.declared.session_tables import mean_by_session
from slipscale.analysis.tasks.matching import figures, section, sentences, table
from slipscale.analysis.tasks.matching.reading import TRIALS
from slipscale.analysis.tasks.matching.statistics import MATCHING

ANALYSIS = of_one_statistic(
    "matching",
    TRIALS,
    MATCHING,
    question="Which {q.level} feels the same as a reference?",
    what="matching",
    title="Matching",
    answers=sentences.matching_sentences,
    sentences=sentences.matching_sentences,
    blocks=section.blocks,
    figures=lambda found, trials, q: {
        f"matching_{task}": figures.matches(
            [each for each in found if each.task == task], trials[trials["task"] == task], q
        )
        for task in sorted({each.task for each in found})
    },
    table=table.matching_table,
    session_tables=mean_by_session(
        TRIALS,
        "match less reference",
        "{q.unit_in_short}",
        lambda rows: (rows["matched_um_pp"] - rows["reference_um_pp"]).astype(float),
    ),
)
