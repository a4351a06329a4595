"""Write the sentences on maps of dissimilarities."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.writing.numbers import counted, unit_number

if TYPE_CHECKING:
    from slipscale.analysis.tasks.similarity.statistics import TaskMap
    from slipscale.stimuli.quantity import Quantity


def answers(
    found: tuple[TaskMap | NotComputed, ...], _confidence: float, _quantity: Quantity
) -> list[str]:
    """Return one sentence per task: the stress of maps by their dimensions."""
    return [_answer(each) for each in found]


def _answer(found: TaskMap | NotComputed) -> str:
    if isinstance(found, NotComputed):
        return f"No map of the dissimilarities was computed: {found.reason}."
    stress = ", ".join(unit_number(value, 3) for value in found.stress.values())
    people = counted(found.participants, "participant", "participants")
    dimensions = ", ".join(map(str, found.stress))
    return (
        f"Non-metric multidimensional scaling of {len(found.items)} items ({found.task}; {people}) "
        f"has a stress-1 of {stress} in {dimensions} dimensions."
    )
