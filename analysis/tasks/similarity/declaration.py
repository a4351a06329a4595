"""Declare dissimilarity ratings of pairs, and free sorting."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from slipscale.analysis.statistics.not_computed import all_computed
from slipscale.analysis.tasks.declared.one_statistic import of_one_statistic
from slipscale.analysis.tasks.similarity import figures, section, sentences
from slipscale.analysis.tasks.similarity.reading import TRIALS
from slipscale.analysis.tasks.similarity.statistics import SIMILARITY

if TYPE_CHECKING:
    from slipscale.analysis.statistics.not_computed import NotComputed
    from slipscale.analysis.tasks.similarity.statistics import TaskMap


def _table(found: tuple[TaskMap | NotComputed, ...]) -> pd.DataFrame:
    rows = [
        {"task": task.task, "item": item}
        | {f"axis_{number}": value for number, value in enumerate(place, start=1)}
        for task in all_computed(found)
        for item, place in task.coordinates.items()
    ]
    return pd.DataFrame(rows)


ANALYSIS = of_one_statistic(
    "similarity",
    TRIALS,
    SIMILARITY,
    question="How different do pairs of {q.stimuli} feel, and along how many dimensions?",
    what="dissimilarities",
    title="Dissimilarities",
    answers=sentences.answers,
    sentences=sentences.answers,
    blocks=section.blocks,
    figures=lambda found, _trials, _q: {
        f"similarity_{each.task}": figures.similarity(each) for each in all_computed(found)
    },
    table=_table,
)
