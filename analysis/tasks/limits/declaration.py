"""Define how the method of limits is analysed and reported."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from slipscale.analysis.json_form import JsonObject
from slipscale.analysis.statistics.not_computed import NotComputed, computed
from slipscale.analysis.tasks.declared.flat_table import flat_rows
from slipscale.analysis.tasks.declared.one_statistic import Blocks, Figures, OneStatistic, Svgs
from slipscale.analysis.tasks.limits.statistics import LIMITS, TRIALS, TaskLimits
from slipscale.analysis.writing import html
from slipscale.analysis.writing.numbers import (
    bracketed,
    counted,
    level_of,
    number,
    p_value,
)
from slipscale.analysis.writing.points import SIZE, draw_means, draw_people
from slipscale.analysis.writing.verdicts import DIFFERED, verdict
from slipscale.figure_style import canvas, styled
from slipscale.stimuli.quantity import Quantity

HEADS = ("Participant", "Ascending", "Descending", "Threshold", "Transitions")
NAMES = ("Ascending", "Descending", "Both")


@styled
def transitions(task: TaskLimits, quantity: Quantity) -> Figure:
    """Plot mean transitions by direction, for participants and for the group."""
    figure, axes = canvas(size=SIZE)
    rows = [(p.ascending_level, p.descending_level, p.threshold_level) for p in task.people]
    draw_people(axes, np.arange(3.0), np.array(rows, np.float64))
    for place, each in enumerate(
        (task.ascending_level, task.descending_level, task.threshold_level)
    ):
        if found := computed(each):
            draw_means(axes, np.array([float(place)]), [found.mean], [found.interval])
    axes.set_xticks(range(3), NAMES)
    axes.set_ylabel(quantity.headed("Transition"))
    axes.set_xlabel("Series")
    return figure


class _Limits(OneStatistic[TaskLimits]):
    name = "limits"
    trials = TRIALS
    statistics = (LIMITS,)
    question = "At which {q.level} does the answer change in series of {q.levels}?"
    what = "method-of-limits"
    title = "Method of limits"

    def task_answer(self, task: TaskLimits, confidence: float, quantity: Quantity) -> str:
        threshold, named = task.threshold_level, self.task_name(task, quantity)
        if isinstance(threshold, NotComputed):
            return f"{named}: no threshold was computed ({threshold.reason})."
        standard = task.standard_level
        of = "" if standard is None else f" against a standard of {quantity.value(standard)}"
        return (
            f"{named}, {counted(task.series, 'series', 'series')} from "
            f"{counted(task.participants, 'participant', 'participants')}: the answer changed at "
            f"{quantity.value(f'{threshold.mean:.3g}')}{of}, {level_of(confidence)} CI "
            f"{bracketed(threshold.interval, lambda value: number(value, 3))}."
        )

    def task_remarks(self, task: TaskLimits, confidence: float, quantity: Quantity) -> list[str]:
        remarks, error = [], task.constant_error_level
        beyond = task.unexpected_error_level
        if not isinstance(error, NotComputed):
            text = (
                "Transitions of descending series were "
                f"{quantity.value(number(error.mean, 3))} higher than those of ascending series. "
            )
            remarks.append(
                f"{text}Anticipation and habituation were not tested: {beyond.reason}."
                if isinstance(beyond, NotComputed)
                else f"{text}Noise alone causes "
                f"{quantity.value(number(task.expected_error_level, 3))}, because a chance answer "
                "ends a series."
            )
        if not isinstance(beyond, NotComputed):
            verb = verdict(DIFFERED, beyond.p, confidence, beyond.df)
            remarks.append(
                f"The difference between directions {verb} from that expected without anticipation "
                f"and habituation (by {quantity.value(number(beyond.mean, 3))}, t({beyond.df}) = "
                f"{number(beyond.t)}, {p_value(beyond.p)})."
            )
        if task.without_transition:
            remarks.append(
                f"{task.without_transition} of {task.series} series had no transition and were "
                "left out."
            )
        return remarks

    def task_blocks(self, task: TaskLimits, svgs: Svgs, level: float, quantity: Quantity) -> Blocks:
        rows = [
            [
                each.participant,
                number(each.ascending_level, 3),
                number(each.descending_level, 3),
                number(each.threshold_level, 3),
                str(each.transitions),
            ]
            for each in task.people
        ]
        return [
            *html.figure_if_drawn(
                svgs,
                f"limits_{task.task}",
                "Individual participants' mean transitions (pale) in ascending and descending "
                f"series; blue: means with a t-based {level:g} % interval.",
                "Mean transitions of ascending and descending series",
            ),
            html.table(
                html.columns(*HEADS, left=1),
                rows,
                f"Mean transitions in {quantity.unit}{quantity.behind}; the threshold is the mean "
                "of both directions.",
            ),
        ]

    def task_figures(self, task: TaskLimits, _: object, quantity: Quantity) -> Figures:
        return {f"limits_{task.task}": transitions(task, quantity)}

    def task_rows(self, task: TaskLimits) -> list[JsonObject]:
        return flat_rows({"task": task.task}, task.people)


ANALYSIS = _Limits()
