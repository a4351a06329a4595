"""Define how the identification task is analysed and reported."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.statistics.not_computed import fold
from slipscale.analysis.tasks.declared.one_statistic import Blocks, Figures, OneStatistic, Svgs
from slipscale.analysis.tasks.identification.statistics import (
    IDENTIFICATION,
    TRIALS,
    TRIALS_PER_CELL,
    TaskIdentification,
)
from slipscale.analysis.writing import html
from slipscale.analysis.writing.numbers import bracketed, counted, level_of, number
from slipscale.figure_style import canvas, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.analysis.json_form import JsonObject
    from slipscale.stimuli.quantity import Quantity


#: Proportions above this value are written in white.
DARK = 0.5


@styled
def named(task: TaskIdentification) -> Figure:
    """Plot the confusion matrix as proportions of the answers to each surface."""
    figure, axes = canvas(size=(4.6, 4.2))
    counts = np.array(task.table, np.float64)
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    axes.imshow(shares, cmap="Blues", vmin=0, vmax=1)
    for (row, column), share in np.ndenumerate(shares):
        axes.text(
            column,
            row,
            f"{100 * share:.0f}",
            ha="center",
            va="center",
            fontsize=8.5,
            color="white" if share > DARK else "black",
        )
    places = range(len(task.items))
    axes.set_xticks(places, task.items)
    axes.set_yticks(places, task.items)
    axes.grid(visible=False)
    axes.set_xlabel("Named")
    axes.set_ylabel("Presented (answers in %)")
    return figure


class _Identification(OneStatistic[TaskIdentification]):
    name = "identification"
    trials = TRIALS
    statistics = (IDENTIFICATION,)
    question = "How many {q.stimuli} can be identified?"
    what = "identification"
    title = "Identification"

    def task_answer(self, task: TaskIdentification, confidence: float, quantity: Quantity) -> str:
        share = fold(
            task.share_right,
            lambda mean: (
                f" {100 * mean.mean:.0f} % of answers were correct, {level_of(confidence)} CI "
                f"{bracketed(mean.interval, lambda value: f'{100 * value:.0f}')}."
            ),
            lambda _: "",
        )
        people = counted(task.participants, "participant", "participants")
        return (
            f"{self.task_name(task, quantity)}, {counted(task.answers, 'answer', 'answers')} from "
            f"{people}: {number(task.corrected_bits)} of {number(task.most_bits)} bits were "
            f"transferred (uncorrected: {number(task.information_bits)}), as if "
            f"{number(2**task.corrected_bits, 1)} {quantity.stimuli} were identified without "
            f"error.{share}"
        )

    def task_doubts(
        self, task: TaskIdentification, _confidence: float, quantity: Quantity
    ) -> list[str]:
        if task.trials_per_cell >= TRIALS_PER_CELL:
            return []
        text = (
            f"{self.task_name(task, quantity)}: each participant has {task.trials_per_cell:.1f} "
            f"trials per cell of the table; with fewer than {TRIALS_PER_CELL}, individual "
            "information is overestimated despite the correction."
        )
        return [text]

    def task_blocks(
        self, task: TaskIdentification, svgs: Svgs, _level: float, quantity: Quantity
    ) -> Blocks:
        return [
            *html.figure_if_drawn(
                svgs,
                f"identification_{task.task}",
                "Proportion of answers for each presented surface; correct answers are on the "
                "diagonal.",
                "Table of presented surfaces against named surfaces: " + ", ".join(task.items),
            ),
            html.table(
                html.columns("Presented", *task.items, left=1),
                [[item, *map(str, row)] for item, row in zip(task.items, task.table, strict=True)],
                f"Counts of answers: presented {quantity.stimuli} (rows) and named "
                f"{quantity.stimuli} (columns). Mean information per participant: "
                f"{number(task.mean_information_bits)} bits (no interval, because the estimates of "
                "individual participants remain biased).",
            ),
        ]

    def task_figures(self, task: TaskIdentification, _: object, _quantity: Quantity) -> Figures:
        return {f"identification_{task.task}": named(task)}

    def task_rows(self, task: TaskIdentification) -> list[JsonObject]:
        return [
            {"task": task.task, "presented": item, "named": other, "answers": count}
            for item, row in zip(task.items, task.table, strict=True)
            for other, count in zip(task.items, row, strict=True)
        ]


ANALYSIS = _Identification()
