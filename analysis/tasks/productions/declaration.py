"""Declare magnitude production."""

from __future__ import annotations

from slipscale.analysis.tasks.declared.flat_table import flat_under
from slipscale.analysis.tasks.declared.one_statistic import of_each, of_one_statistic
from slipscale.analysis.tasks.declared.session_tables import logarithms, mean_by_session
from slipscale.analysis.tasks.productions import figures, section, sentences
from slipscale.analysis.tasks.productions.reading import TRIALS
from slipscale.analysis.tasks.productions.statistics import PRODUCTIONS

ANALYSIS = of_one_statistic(
    "productions",
    TRIALS,
    PRODUCTIONS,
    question="Which {q.levels} are as {q.adjective} as given numbers?",
    what="magnitude production",
    title="Magnitude production",
    answers=lambda found, level, q: [
        text for task in found for text in sentences.production_answers(task, level, q)
    ],
    sentences=sentences.production_sentences,
    blocks=of_each(section.blocks),
    figures=lambda found, trials, q: {
        f"productions_{each.task}": figures.productions(
            each, trials[trials["task"] == each.task], q
        )
        for each in found
    },
    table=lambda found: flat_under(
        [
            (
                {
                    "task": task.task,
                    "standard_um_pp": task.standard_um_pp,
                    "modulus": task.modulus,
                },
                each,
            )
            for task in found
            for each in task.numbers
        ]
    ),
    session_tables=mean_by_session(
        TRIALS,
        "mean produced {q.level}",
        "natural logarithm, {q.unit_in_short}",
        lambda rows: logarithms(rows["produced_um_pp"]),
    ),
)
