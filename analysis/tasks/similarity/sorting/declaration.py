"""Declare free sorting."""

from __future__ import annotations

from dataclasses import replace

from slipscale.analysis.statistics.not_computed import all_computed
from slipscale.analysis.tasks.declared.one_statistic import of_one_statistic
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.tasks.similarity import declaration as similarity
from slipscale.analysis.tasks.similarity.sorting.reading import TRIALS
from slipscale.analysis.tasks.similarity.sorting.statistics import SORTING
from slipscale.analysis.writing.numbers import counted


def _design(analysis: Analysis) -> list[str]:
    found = all_computed(analysis.inference.found(SORTING) or ())
    return [
        f"{counted(len(task.items), 'item', 'items')} sorted by "
        f"{counted(task.participants, 'participant', 'participants')}"
        for task in found
    ]


ANALYSIS = replace(
    of_one_statistic(
        "sorting",
        TRIALS,
        SORTING,
        question="Which {q.stimuli} feel alike, and along how many dimensions do they differ?",
        what="sorting",
        title="Free sorting",
        named=lambda task, _q: similarity.named(task, "Free sorting"),
        answers=lambda task, _level, _q: [similarity.answer(task, "Free sorting")],
        blocks=lambda task, svgs, _level, q: similarity.blocks(task, svgs, q, "sorting"),
        figures=lambda task, _trials, _q: {
            f"sorting_{each.task}": similarity.similarity(each) for each in all_computed([task])
        },
        rows=similarity.rows,
    ),
    design=_design,
)
