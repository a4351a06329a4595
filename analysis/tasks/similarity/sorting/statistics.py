"""Compute multidimensional scaling of sorted items."""

from __future__ import annotations

from slipscale.analysis.reading.task_tables import by_task
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Inputs, Statistic
from slipscale.analysis.tasks.similarity.sorting.reading import TRIALS, sorted_items
from slipscale.analysis.tasks.similarity.statistics import SIMILARITY, TaskMap, map_of


def maps(inputs: Inputs) -> tuple[TaskMap | NotComputed, ...] | NotComputed:
    """Return the multidimensional scaling map for each task, if the study chose such maps."""
    chosen, trials = inputs.data.choices.tests, inputs.data.of(TRIALS)
    if chosen is not None and SIMILARITY.key not in chosen:
        return NotComputed("not chosen in the study file")
    if not len(trials):
        return NotComputed("no sorted items")
    return tuple(
        map_of(task, rows, sorted_items=sorted_items(rows)) for task, rows in by_task(trials)
    )


class _Sorting(Statistic[tuple[TaskMap | NotComputed, ...]]):
    key = "sorting"
    meaning = "sorted groups: non-metric multidimensional scaling (chosen with similarity)"
    test = False
    methods = (
        "The dissimilarity of two sorted items is the proportion of participants who put them "
        "into different groups. Dissimilarities were scaled by non-metric multidimensional scaling "
        "[[kruskal1964]] with the primary treatment of ties."
    )

    compute = staticmethod(maps)


SORTING = _Sorting()
