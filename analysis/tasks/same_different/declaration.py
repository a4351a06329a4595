"""Define how the same–different task is analysed and reported."""

from __future__ import annotations

from math import isfinite

import numpy as np
from matplotlib.figure import Figure

from slipscale.analysis.json_form import JsonObject, renamed
from slipscale.analysis.reading.surface_labels import with_unit
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.mean_over_participants import EstimatedMean
from slipscale.analysis.statistics.not_computed import computed
from slipscale.analysis.tasks.declared.flat_table import flat_rows
from slipscale.analysis.tasks.declared.one_statistic import Blocks, Figures, OneStatistic, Svgs
from slipscale.analysis.tasks.same_different.statistics import (
    SAME_DIFFERENT,
    TRIALS,
    PairSensitivity,
    TaskPairs,
)
from slipscale.analysis.writing import html
from slipscale.analysis.writing.numbers import bracketed, cell, counted, joined, level_of, number
from slipscale.analysis.writing.points import SIZE, draw_means
from slipscale.figure_style import GREY, ORANGE, canvas, styled
from slipscale.stimuli.quantity import Quantity

HEADS = (
    *("Pair", "Participants", "Different, called different", "Same, called different"),
    *("d'", "Criterion k", "Mean d'", "CI"),
)


def _pair(pair: PairSensitivity, quantity: Quantity) -> str:
    return f"{with_unit(pair.first, quantity)} and {with_unit(pair.second, quantity)}"


def _d_prime(pair: PairSensitivity, confidence: float) -> str:
    mean = computed(pair.mean_d_prime)
    if not pair.at_ceiling:
        return number(pair.d_prime)
    if mean and isfinite(mean.interval.low):
        return f"at least {number(mean.interval.low)}, {level_of(confidence)} bound of the mean,"
    return "without an upper bound"


def _bounds(mean: EstimatedMean) -> str:
    low, high = mean.interval
    if isfinite(low) and isfinite(high):
        return bracketed(mean.interval)
    return f"≥ {number(low)}" if isfinite(low) else f"≤ {number(high)}"


def _drawn(mean: EstimatedMean) -> ConfidenceInterval:
    low, high = (end if isfinite(end) else mean.mean for end in mean.interval)
    return ConfidenceInterval(low, high, mean.interval.confidence)


@styled
def sensitivities(task: TaskPairs) -> Figure:
    """Plot d' for each pair: the mean across participants, and the value from pooled answers."""
    figure, axes = canvas(size=SIZE)
    for place, each in enumerate(task.pairs):
        if found := computed(each.mean_d_prime):
            draw_means(axes, np.array([float(place)]), [found.mean], [_drawn(found)])
        axes.plot([place], [each.d_prime], "x", color=ORANGE, markersize=6, zorder=5)
    names = [f"{each.first}\n{each.second}" for each in task.pairs]
    axes.set_xticks(range(len(names)), names)
    axes.axhline(0, color=GREY, linewidth=0.8, linestyle=":", zorder=0)
    axes.set_xlabel("Pair")
    axes.set_ylabel("d' (differencing model)")
    return figure


#: Largest number of participants with a caution on intervals of the mean d' (`benchmarks.truths`).
FEW_PEOPLE = 4
FEW = (
    "{name}: with {people} participants, intervals of the mean d' are too narrow. In simulations "
    "of 3 people who hardly told surfaces apart, 95 % intervals contained the true mean in 88 %."
)


class _SameDifferent(OneStatistic[TaskPairs]):
    name = "same_different"
    trials = TRIALS
    statistics = (SAME_DIFFERENT,)
    question = "Which pairs of {q.stimuli} can be told apart?"
    what = "same–different"
    title = "Same–different"

    def task_answer(self, task: TaskPairs, confidence: float, quantity: Quantity) -> str:
        pairs = [f"{_d_prime(each, confidence)} ({_pair(each, quantity)})" for each in task.pairs]
        return (
            f"{self.task_name(task, quantity)}, {counted(task.answers, 'answer', 'answers')} from "
            f"{counted(task.participants, 'participant', 'participants')}: d' by the "
            f"differencing model was {joined(pairs)}."
        )

    def task_doubts(self, task: TaskPairs, _confidence: float, quantity: Quantity) -> list[str]:
        if task.participants > FEW_PEOPLE or not any(each.mean_d_prime for each in task.pairs):
            return []
        return [FEW.format(name=self.task_name(task, quantity), people=task.participants)]

    def task_blocks(self, task: TaskPairs, svgs: Svgs, level: float, quantity: Quantity) -> Blocks:
        rows = [
            [
                _pair(each, quantity),
                str(each.participants),
                f"{each.different} of {each.different_n}",
                f"{each.same} of {each.same_n}",
                number(each.d_prime),
                number(each.criterion),
                cell(each.mean_d_prime, lambda mean: number(mean.mean)),
                cell(each.mean_d_prime, _bounds),
            ]
            for each in task.pairs
        ]
        return [
            *html.figure_if_drawn(
                svgs,
                f"same_different_{task.task}",
                f"Mean d' across participants with a t-based {level:g} % interval; crosses: d' of "
                "all answers pooled. At d' = 0 (dotted), participants cannot tell the pair apart; "
                "d' is negative if “different” was less frequent for the pair than for same "
                "surfaces. A bar that ends at the mean has no bound on this side, because a "
                "participant made no error.",
                "d' of " + ", ".join(_pair(each, quantity) for each in task.pairs),
            ),
            html.table(
                html.columns(*HEADS, left=1),
                rows,
                f"Pairs of {quantity.stimuli}. d' and k are in units of the standard deviation of "
                "one sensation: two sensations more than k apart are called different.",
            ),
        ]

    def task_figures(self, task: TaskPairs, _: object, _quantity: Quantity) -> Figures:
        return {f"same_different_{task.task}": sensitivities(task)}

    def task_rows(self, task: TaskPairs) -> list[JsonObject]:
        pairs = [
            renamed(each, mean_d_prime="") | {"at_ceiling": each.at_ceiling} for each in task.pairs
        ]
        return flat_rows({"task": task.task}, pairs)


ANALYSIS = _SameDifferent()
