"""Define how the pointing task is analysed and reported."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from slipscale.analysis.json_form import JsonObject, renamed
from slipscale.analysis.statistics.not_computed import computed, fold
from slipscale.analysis.tasks.declared.flat_table import flat_rows
from slipscale.analysis.tasks.declared.one_statistic import Blocks, Figures, OneStatistic, Svgs
from slipscale.analysis.tasks.pointing.statistics import (
    FEWEST,
    POINTING,
    TRIALS,
    FeedbackPointing,
    MeanOrReason,
    TaskPointing,
)
from slipscale.analysis.writing import html
from slipscale.analysis.writing.axes import LINES_AT_MOST
from slipscale.analysis.writing.numbers import (
    DASH,
    bracketed,
    counted,
    level_of,
    number,
    p_value,
)
from slipscale.analysis.writing.points import SIZE
from slipscale.analysis.writing.verdicts import CHANGED, verdict
from slipscale.figure_style import BLUE, ORANGE, PALE, canvas, styled
from slipscale.stimuli.quantity import Quantity

HEADS = ("Movements", "Errors", "Movement time (s)", "Throughput (bit/s)", "a (s)", "b (s/bit)")


def _mean(found: MeanOrReason, digits: int = 2) -> str:
    return fold(
        found,
        lambda mean: (
            f"{number(mean.mean, digits)} "
            f"{bracketed(mean.interval, lambda end: number(end, digits))}"
        ),
        lambda _reason: DASH,
    )


def _throughput(task: str, found: FeedbackPointing, confidence: float) -> str:
    named = f"{task}, feedback condition “{found.feedback}”"
    people = counted(len(found.people), "participant", "participants")
    return fold(
        found.throughput_bit_s,
        lambda mean: (
            f"{named}: the throughput was {number(mean.mean)} bit/s, "
            f"{level_of(confidence)} CI {bracketed(mean.interval, number)}, from "
            f"{found.movements} movements of {people}."
        ),
        lambda reason: f"{named}: the throughput was not computed ({reason}).",
    )


def _gain(name: str, task: TaskPointing, confidence: float) -> list[str]:
    rate, time = task.throughput_gain_bit_s, task.time_gain_s
    if not (rate and time):
        return []
    verb, then = (verdict(CHANGED, each.p, confidence, each.df) for each in (rate, time))
    return [
        (
            f"{name}: with feedback, throughput {verb} (difference "
            f"{number(rate.mean)} bit/s, t({rate.df}) = {number(rate.t)}, "
            f"{p_value(rate.p)}), and movement time {then} "
            f"(difference {number(time.mean, 3)} s, {level_of(confidence)} CI "
            f"{bracketed(time.interval, lambda end: number(end, 3))}, {p_value(time.p)})."
        )
    ]


@styled
def movement_times(task: TaskPointing) -> Figure:
    """Plot movement times, with their means and the mean regression line per condition."""
    figure, axes = canvas(size=SIZE)
    for condition, colour in zip(task.conditions, (BLUE, ORANGE), strict=False):
        cells = [cell for each in condition.people for cell in each.cells]
        if not cells:
            continue
        for each in condition.people[:LINES_AT_MOST]:
            bits, times = [c.bits for c in each.cells], [c.movement_time_s for c in each.cells]
            axes.plot(bits, times, "o", color=PALE, markersize=2.5, zorder=1)
        ends = np.unique([cell.bits for cell in cells])
        means = [np.mean([c.movement_time_s for c in cells if c.bits == bits]) for bits in ends]
        axes.plot(ends, means, "o", color=colour, zorder=4, label=f"feedback: {condition.feedback}")
        intercept, slope = computed(condition.intercept_s), computed(condition.slope_s_per_bit)
        if intercept and slope:
            axes.plot(ends, intercept.mean + slope.mean * ends, color=colour, zorder=3)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("Index of difficulty (bit)")
    axes.set_ylabel("Movement time (s)")
    if len(task.conditions) > 1:
        axes.legend()
    return figure


class _Pointing(OneStatistic[TaskPointing]):
    name = "pointing"
    trials = TRIALS
    statistics = (POINTING,)
    question = "How fast and how precisely do people point?"
    what = "pointing"
    title = "Pointing"

    def task_answers(self, task: TaskPointing, confidence: float, quantity: Quantity) -> list[str]:
        """Return a sentence on each condition and on the effect of feedback."""
        name = self.task_name(task, quantity)
        return [
            *(_throughput(name, each, confidence) for each in task.conditions),
            *_gain(name, task, confidence),
        ]

    def task_remarks(self, task: TaskPointing, _confidence: float, _q: Quantity) -> list[str]:
        sentences = []
        for each in task.conditions:
            sentences.append(
                f"Feedback condition “{each.feedback}”: movement time = a + b × index of "
                f"difficulty, with a = {_mean(each.intercept_s, 3)} s and b = "
                f"{_mean(each.slope_s_per_bit, 3)} s/bit."
            )
            if each.left_out:
                sentences.append(
                    f"{each.left_out} combinations of participant, distance and width have fewer "
                    f"than {FEWEST} movements, no spread, or a mean movement away from the target, "
                    "and are left out."
                )
        return sentences

    def task_blocks(
        self, task: TaskPointing, svgs: Svgs, level: float, _quantity: Quantity
    ) -> Blocks:
        rows = [
            [
                each.feedback,
                str(each.movements),
                _mean(each.error_share),
                _mean(each.movement_time_s),
                _mean(each.throughput_bit_s),
                _mean(each.intercept_s, 3),
                _mean(each.slope_s_per_bit, 3),
            ]
            for each in task.conditions
        ]
        return [
            *html.figure_if_drawn(
                svgs,
                f"pointing_{task.task}",
                "Mean movement time by index of difficulty. Pale: participants; lines: means of "
                "participants' regressions.",
                "Movement time by index of difficulty",
            ),
            html.table(
                html.columns("Feedback", *HEADS, left=1),
                rows,
                f"Means across participants with {level:g} % intervals. Errors: proportion of "
                "selections that missed the target.",
            ),
        ]

    def task_figures(self, task: TaskPointing, _: object, _quantity: Quantity) -> Figures:
        return {f"pointing_{task.task}": movement_times(task)}

    def task_rows(self, task: TaskPointing) -> list[JsonObject]:
        return [
            row
            for each in task.conditions
            for row in flat_rows(
                {"task": task.task, "feedback": each.feedback},
                [renamed(person, cells="") for person in each.people],
            )
        ]


ANALYSIS = _Pointing()
