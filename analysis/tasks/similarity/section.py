"""Write the section on maps of dissimilarities: the map, its stress, and the weights of people."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import TableColumn
from slipscale.analysis.writing.numbers import number, unit_number

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.similarity.statistics import TaskMap
    from slipscale.stimuli.quantity import Quantity


def blocks(
    tasks: tuple[TaskMap | NotComputed, ...],
    svgs: Mapping[str, str],
    _level: float,
    _quantity: Quantity,
) -> list[Markup]:
    """Return the section of dissimilarity ratings."""
    return [block for task in tasks for block in _task(task, svgs)]


def _task(task: TaskMap | NotComputed, svgs: Mapping[str, str]) -> list[Markup]:
    if isinstance(task, NotComputed):
        return [html.paragraph(f"Map: {task.reason}.", "note")]
    axes = [f"Axis {place + 1}" for place in range(len(next(iter(task.coordinates.values()))))]
    return [
        html.heading(task.task),
        *html.figure_if_drawn(
            svgs,
            f"similarity_{task.task}",
            "Left: the group's map on its principal axes; its unit is arbitrary. Right: stress-1 "
            "by dimensions, 0 if distances are in the order of all dissimilarities. Stress falls "
            "with every dimension; one that adds little is not needed.",
            "Map of " + ", ".join(task.items),
        ),
        html.table(
            [TableColumn(title="Item", left=True), *(TableColumn(title=axis) for axis in axes)],
            [[item, *map(number, place)] for item, place in task.coordinates.items()],
            "Places on the map's principal axes.",
        ),
        *([_weights(task, axes)] if task.people else []),
    ]


def _weights(task: TaskMap, axes: list[str]) -> Markup:
    return html.table(
        [
            TableColumn(title="Participant", left=True),
            *(TableColumn(title=f"Weight of {axis.lower()}") for axis in axes),
            TableColumn(title="r²"),
        ],
        [
            [each.participant, *map(number, each.weights), unit_number(each.r2)]
            for each in task.people
        ],
        "Weights of squared distances along the group's axes, of participants who rated every "
        "pair; r²: proportion of the variance of their squared dissimilarities. The axes are "
        "those of the group's map, and are not estimated from the weights as in INDSCAL.",
    )
