"""Declare magnitude production."""

from __future__ import annotations

from collections.abc import Iterator
from math import exp

import numpy as np
import pandas as pd
from markupsafe import Markup
from matplotlib.figure import Figure

from slipscale.analysis.json_form import JsonObject
from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.statistics.not_computed import NotComputed, fold
from slipscale.analysis.statistics.regression import fit_lines
from slipscale.analysis.statistics.statistic import SessionTable
from slipscale.analysis.tasks.declared.flat_table import flat_rows
from slipscale.analysis.tasks.declared.one_statistic import Blocks, Figures, OneStatistic, Svgs
from slipscale.analysis.tasks.declared.session_tables import logarithms, mean_by_session
from slipscale.analysis.tasks.productions.statistics import (
    MOST_AT_BOUNDS,
    PRODUCTIONS,
    TRIALS,
    BothExponents,
    TaskProductions,
)
from slipscale.analysis.tasks.ratios.statistics import log_cells
from slipscale.analysis.writing import html
from slipscale.analysis.writing.numbers import (
    bracketed,
    counted,
    joined,
    level_of,
    number,
    significant,
)
from slipscale.analysis.writing.points import (
    SIZE,
    draw_means,
    draw_people,
    draw_standard,
    make_logarithmic,
)
from slipscale.figure_style import BLUE, canvas, styled
from slipscale.stimuli.quantity import Quantity, capitalised


def _answer(name: str, found: TaskProductions, confidence: float, quantity: Quantity) -> str:
    what = (
        f"{name}, {counted(found.answers, 'production', 'productions')} by "
        f"{counted(found.participants, 'participant', 'participants')}, with a standard of "
        f"{quantity.value(found.standard_level)} called {found.modulus:g}"
    )
    slope = found.slope
    if isinstance(slope, NotComputed):
        return f"{what}: no exponent was computed ({slope.reason})."
    grew = (
        f"{what}: log {quantity.level} grew by {number(slope.mean)} per unit of the log "
        f"number (mean of participants' slopes), {level_of(confidence)} CI "
        f"{bracketed(slope.interval)}"
    )
    if found.exponent is None:
        return f"{grew}; the slope is not above 0, so there is no exponent."
    if found.exponent_interval is None:
        return (
            f"{grew}, which corresponds to an exponent of {number(found.exponent)}, whose interval "
            "has no upper bound."
        )
    return (
        f"{grew}, which corresponds to an exponent of {number(found.exponent)}, CI "
        f"{bracketed(found.exponent_interval)}."
    )


def _both(found: BothExponents, confidence: float) -> str:
    low, high = found.ratio_interval
    differs = (
        "which is compatible with no difference"
        if low <= 1 <= high
        else "consistent with the regression bias in magnitude production"
        if found.ratio > 1
        else "opposite to the regression bias in magnitude production"
    )
    whom = f"the {found.n} participants who did both tasks"
    if found.n < found.participants:
        whom = (
            f"the {found.n} of {found.participants} participants with an exponent above 0 in both "
            "tasks"
        )
    return (
        f"For {whom}, the exponent of production was "
        f"{number(found.production)} and the exponent of {found.counterpart} was "
        f"{number(found.estimation)} (geometric means). The ratio was {number(found.ratio)}, "
        f"{level_of(confidence)} CI {bracketed(found.ratio_interval)}, {differs}. The usual remedy "
        "(Stevens & Greenbaum, 1966) is the geometric mean of the two exponents, "
        f"{number(found.combined)}, CI {bracketed(found.combined_interval)}."
    )


def _alone(reason: str) -> list[Markup]:
    return [
        html.paragraph(
            f"Not compared with an estimation exponent: {reason}. An exponent from "
            "production alone is biased; add a magnitude_estimation task to the study to measure "
            "the bias.",
            "note",
        )
    ]


def _production_table(task: TaskProductions, quantity: Quantity) -> Markup:
    convention = f" ({quantity.convention})" if quantity.convention else ""
    level = quantity.heading(quantity.title)
    titles = ("Number", "Participants", "Productions", "At the limits", level, "CI")
    return html.table(
        html.columns(*titles),
        [
            [
                f"{each.number:g}",
                str(each.participants),
                str(each.productions),
                str(each.at_bounds),
                significant(each.level),
                bracketed(each.interval, significant),
            ]
            for each in task.numbers
        ],
        f"{capitalised(quantity.levels)}{convention} produced for each number, with the standard "
        f"of {quantity.value(task.standard_level)} called {task.modulus:g}: geometric mean of "
        "participants' geometric means, with a t-based interval computed on logarithms.",
    )


@styled
def productions(found: TaskProductions, trials: pd.DataFrame, quantity: Quantity) -> Figure:
    """Plot produced levels against numbers on logarithmic axes."""
    figure, axes = canvas(size=SIZE)
    table = log_cells(trials[~trials["catch"]], "number", "produced_level")
    numbers = table.columns.to_numpy(float)
    draw_people(axes, numbers, np.exp(table.to_numpy(float)))
    means = [each.level for each in found.numbers]
    draw_means(axes, numbers, means, [each.interval for each in found.numbers])
    if found.slope:
        line = fit_lines(np.log(numbers), np.log(means))
        axes.plot(
            numbers, np.exp(line.intercept + line.slope * np.log(numbers)), color=BLUE, zorder=2
        )
    draw_standard(axes, found.modulus, found.standard_level)
    make_logarithmic(axes, np.append(numbers, found.modulus))
    axes.set_xlabel("Number shown")
    axes.set_ylabel(quantity.headed(f"{quantity.title} produced"))
    axes.legend(loc="lower right")
    return figure


class _Productions(OneStatistic[TaskProductions]):
    name = "productions"
    trials = TRIALS
    statistics = (PRODUCTIONS,)
    question = "Which {q.levels} match given numbers for {q.judged}?"
    what = "magnitude-production"
    title = "Magnitude production"

    def task_answers(
        self, found: TaskProductions, confidence: float, quantity: Quantity
    ) -> list[str]:
        texts = [_answer(self.task_name(found, quantity), found, confidence, quantity)]
        if found.both:
            texts.append(_both(found.both, confidence))
        return texts

    def task_remarks(
        self, found: TaskProductions, confidence: float, quantity: Quantity
    ) -> list[str]:
        """Return sentences on starting amplitudes, adjustment limits and catch trials."""
        texts = []
        beginning = found.beginning
        if beginning:
            percent = 100 * (exp(beginning.mean) - 1)
            low, high = (100 * (exp(bound) - 1) for bound in beginning.interval)
            texts.append(
                f"Adjustments that started high ended {number(abs(percent), 1)} % "
                f"{'higher' if percent >= 0 else 'lower'} than adjustments that started low, "
                f"{level_of(confidence)} CI of the difference [{number(low, 1)}, "
                f"{number(high, 1)}] %."
            )
        if found.at_bounds:
            texts.append(
                f"{found.at_bounds} of {found.answers} productions ended within one notch of the "
                "adjustment limits. If participants wanted to adjust beyond the limits, the slope "
                "is too small and the exponent too large."
            )
        if piled := [each for each in found.numbers if each.piled]:
            numbers = joined([f"{each.number:g}" for each in piled])
            texts.append(
                f"For the {'number' if len(piled) == 1 else 'numbers'} {numbers}, more than "
                f"{100 * MOST_AT_BOUNDS:g} % of productions ended at the limits. The mean is then "
                "closer to the limit than without it, and has no interval."
            )
        if found.catch_level is not None:
            texts.append(
                f"In {counted(found.catch_trials, 'catch trial', 'catch trials')} with the "
                "standard's number, participants produced "
                f"{quantity.value(significant(found.catch_level))} (the standard is "
                f"{quantity.value(found.standard_level)})."
            )
        return texts

    def task_doubts(
        self, task: TaskProductions, _confidence: float, quantity: Quantity
    ) -> list[str]:
        if task.at_bounds <= MOST_AT_BOUNDS * task.answers:
            return []
        text = (
            f"{self.task_name(task, quantity)}: {task.at_bounds} of {task.answers} productions "
            "ended at the adjustment limits, which makes the exponent too large and its interval "
            "too narrow."
        )
        return [text]

    def task_blocks(
        self, task: TaskProductions, svgs: Svgs, level: float, quantity: Quantity
    ) -> Blocks:
        levels = quantity.levels
        return [
            *html.figure_if_drawn(
                svgs,
                f"productions_{task.task}",
                f"{capitalised(levels)} produced for the numbers shown, on logarithmic axes. Pale: "
                "individual participants' geometric means; blue: the group geometric mean with a "
                f"t-based {level:g} % interval, and the line whose slope is the inverse of the "
                "exponent; black: the standard and its number.",
                f"Geometric mean {levels}: "
                + ", ".join(
                    f"{each.number:g}: {quantity.value(f'{each.level:.3g}')}"
                    for each in task.numbers
                ),
            ),
            _production_table(task, quantity),
            *fold(task.both, lambda _: [], _alone),
        ]

    def task_figures(
        self, task: TaskProductions, trials: pd.DataFrame, quantity: Quantity
    ) -> Figures:
        own = trials[trials["task"] == task.task]
        return {f"productions_{task.task}": productions(task, own, quantity)}

    def task_rows(self, task: TaskProductions) -> list[JsonObject]:
        of_task: JsonObject = {
            "task": task.task,
            "standard_level": task.standard_level,
            "modulus": task.modulus,
        }
        return flat_rows(of_task, task.numbers)

    def session_tables(self, data: Dataset, _prepared: Prepared | None) -> Iterator[SessionTable]:
        return mean_by_session(
            data,
            TRIALS,
            "mean produced {q.level}",
            "natural logarithm, {q.unit_in_short}",
            lambda rows: logarithms(rows["produced_level"]),
        )


ANALYSIS = _Productions()
