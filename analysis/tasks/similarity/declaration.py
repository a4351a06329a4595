"""Declare dissimilarity ratings of pairs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reading.surface_labels import with_unit
from slipscale.analysis.statistics.not_computed import NotComputed, all_computed
from slipscale.analysis.tasks.declared.one_statistic import Figures, OneStatistic
from slipscale.analysis.tasks.similarity.reading import TRIALS
from slipscale.analysis.tasks.similarity.statistics import SIMILARITY, TaskMap
from slipscale.analysis.writing import html
from slipscale.analysis.writing.numbers import counted, joined, number, unit_number
from slipscale.analysis.writing.task_names import task_name
from slipscale.figure_style import BLUE, GREY, canvas, styled

if TYPE_CHECKING:
    from markupsafe import Markup
    from matplotlib.figure import Figure

    from slipscale.analysis.json_form import JsonObject
    from slipscale.stimuli.quantity import Quantity

Task = TaskMap | NotComputed


def _weights(task: TaskMap, axes: list[str]) -> Markup:
    return html.table(
        html.columns("Participant", *(f"Weight of {axis.lower()}" for axis in axes), "r²", left=1),
        [
            [each.participant, *map(number, each.weights), unit_number(each.r2)]
            for each in task.people
        ],
        "Weights of squared distances along the axes of the group map, for participants who rated "
        "every pair. r²: proportion of the variance of a participant's squared dissimilarities "
        "that the weighted distances explain. Unlike in INDSCAL, the axes are not estimated "
        "together with the weights.",
    )


@styled
def similarity(found: TaskMap) -> Figure:
    """Plot the map on its first two principal axes, and stress against number of dimensions."""
    figure, (left, right) = canvas(1, 2, size=(6.8, 3.6), width_ratios=[1.7, 1])
    for item, place in found.coordinates.items():
        x, y = (*place, 0.0)[:2]
        left.plot(x, y, "o", color=BLUE, markersize=6)
        left.annotate(item, (x, y), xytext=(5, 4), textcoords="offset points", fontsize=8.5)
    left.axhline(0, color=GREY, linewidth=0.6, zorder=0)
    left.axvline(0, color=GREY, linewidth=0.6, zorder=0)
    left.set_aspect("equal", adjustable="datalim")
    left.margins(0.15)
    left.set_xlabel("Axis 1")
    left.set_ylabel("Axis 2")
    dimensions = np.array(list(found.stress))
    right.plot(dimensions, list(found.stress.values()), "o-", color=BLUE)
    right.set_xticks(dimensions)
    right.set_ylim(bottom=0)
    right.set_xlabel("Dimensions")
    right.set_ylabel("Stress-1")
    return figure


class MapAnalysis(OneStatistic[Task]):
    """A kind of task whose result is a map of the items; its figure is called like the kind."""

    def task_name(self, task: Task, _quantity: Quantity) -> str:
        """Return the name of a task."""
        return self.title if isinstance(task, NotComputed) else task_name(self.title, task.task)

    def task_answer(self, task: Task, _confidence: float, quantity: Quantity) -> str:
        """Return a sentence that gives the stress of the map for each number of dimensions."""
        if isinstance(task, NotComputed):
            return f"{self.title}: no map was computed ({task.reason})."
        stress = joined(
            [f"{unit_number(value, 3)} ({place}D)" for place, value in task.stress.items()]
        )
        people = counted(task.participants, "participant", "participants")
        return (
            f"{self.task_name(task, quantity)}, {len(task.items)} items, {people}: the stress-1 of "
            f"non-metric multidimensional scaling is {stress}."
        )

    def task_blocks(
        self,
        task: Task,
        svgs: Mapping[str, str],
        _percent: float,
        quantity: Quantity,
    ) -> list[Markup]:
        """Return the figure and the tables for one task."""
        if isinstance(task, NotComputed):
            return [html.paragraph(f"No map was computed: {task.reason}.", "note")]
        axes = [f"Axis {place + 1}" for place in range(len(next(iter(task.coordinates.values()))))]
        return [
            *html.figure_if_drawn(
                svgs,
                f"{self.name}_{task.task}",
                "Left: the group's map on its principal axes; its unit is arbitrary. Right: "
                "stress-1 against the number of dimensions, with primary ties (0 if distances and "
                "dissimilarities are in the same order, in which pairs of equal dissimilarity may "
                "differ in distance). An added dimension never raises stress; a dimension that "
                "barely lowers stress is not needed.",
                "Map of " + ", ".join(with_unit(item, quantity) for item in task.items),
            ),
            html.table(
                html.columns("Item", *axes, left=1),
                [
                    [with_unit(item, quantity), *map(number, place)]
                    for item, place in task.coordinates.items()
                ],
                "Coordinates on the map's principal axes.",
            ),
            *([_weights(task, axes)] if task.people else []),
        ]

    def task_figures(self, task: Task, _: object, _quantity: Quantity) -> Figures:
        """Return the map, if there is one."""
        return {f"{self.name}_{each.task}": similarity(each) for each in all_computed([task])}

    def task_rows(self, task: Task) -> list[JsonObject]:
        """Return one row of coordinates per item."""
        if isinstance(task, NotComputed):
            return []
        return [
            {"task": task.task, "item": item}
            | {f"axis_{number}": value for number, value in enumerate(place, start=1)}
            for item, place in task.coordinates.items()
        ]


class _Similarity(MapAnalysis):
    name = "similarity"
    trials = TRIALS
    statistics = (SIMILARITY,)
    question = "How different do pairs of {q.stimuli} feel, and along how many dimensions?"
    what = "dissimilarity"
    title = "Dissimilarities"


ANALYSIS = _Similarity()
