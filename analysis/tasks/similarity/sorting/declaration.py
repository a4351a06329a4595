"""Declare free sorting."""

from __future__ import annotations

from slipscale.analysis.statistics.not_computed import all_computed
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.tasks.similarity.declaration import MapAnalysis
from slipscale.analysis.tasks.similarity.sorting.reading import TRIALS
from slipscale.analysis.tasks.similarity.sorting.statistics import SORTING
from slipscale.analysis.writing.numbers import counted


class _Sorting(MapAnalysis):
    name = "sorting"
    trials = TRIALS
    statistics = (SORTING,)
    question = "Which {q.stimuli} feel alike, and along how many dimensions do they differ?"
    what = "sorting"
    title = "Free sorting"

    def design(self, analysis: Analysis) -> list[str]:
        found = all_computed(analysis.inference.found(SORTING) or ())
        return [
            f"{counted(len(task.items), 'item', 'items')} sorted by "
            f"{counted(task.participants, 'participant', 'participants')}"
            for task in found
        ]


ANALYSIS = _Sorting()
