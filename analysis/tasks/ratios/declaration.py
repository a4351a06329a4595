"""Declare ratio judgements."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd
from markupsafe import Markup
from matplotlib.figure import Figure

from slipscale.analysis.json_form import JsonObject
from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.regression import fit_lines
from slipscale.analysis.statistics.statistic import SessionTable
from slipscale.analysis.tasks.declared.flat_table import flat_rows
from slipscale.analysis.tasks.declared.one_statistic import Blocks, Figures, OneStatistic, Svgs
from slipscale.analysis.tasks.declared.session_tables import logarithms, mean_by_session
from slipscale.analysis.tasks.ratios.statistics import RATIOS, TRIALS, TaskRatios, log_cells
from slipscale.analysis.writing import html
from slipscale.analysis.writing.numbers import bracketed, counted, level_of, number, significant
from slipscale.analysis.writing.points import SIZE, draw_means, draw_people, make_logarithmic
from slipscale.analysis.writing.task_names import task_name
from slipscale.figure_style import BLUE, GREY, INK, canvas, styled
from slipscale.stimuli.quantity import Quantity


def _ratio_table(task: TaskRatios, quantity: Quantity) -> Markup:
    titles = (quantity.heading(quantity.title), "Participants", "Judgements", "Ratio", "CI")
    return html.table(
        html.columns(*titles),
        [
            [
                f"{each.comparison_level:g}",
                str(each.participants),
                str(each.judgements),
                significant(each.ratio),
                bracketed(each.interval, significant),
            ]
            for each in task.surfaces
        ],
        f"Judged ratio to the standard ({quantity.value(task.standard_level)}{quantity.behind}): "
        "geometric mean of participants' geometric means, with a t-based interval computed on "
        "logarithms.",
    )


@styled
def ratios(found: TaskRatios, trials: pd.DataFrame, quantity: Quantity) -> Figure:
    """Plot judged ratios to the standard on logarithmic axes."""
    figure, axes = canvas(size=SIZE)
    main = trials[~trials["catch"] & (trials["standard_level"] == found.standard_level)]
    table = log_cells(main, "comparison_level", "ratio")
    table = table.loc[:, table.columns.to_numpy(float) > 0]  # 0 has no place on a logarithmic axis
    shown = [each for each in found.surfaces if each.comparison_level > 0]
    amplitudes = table.columns.to_numpy(float)
    draw_people(axes, amplitudes, np.exp(table.to_numpy(float)))
    means = [each.ratio for each in shown]
    draw_means(axes, amplitudes, means, [each.interval for each in shown])
    if found.power_law:
        line = fit_lines(np.log(amplitudes), np.log(means))
        axes.plot(
            amplitudes,
            np.exp(line.intercept + line.slope * np.log(amplitudes)),
            color=BLUE,
            zorder=2,
        )
    axes.plot(
        [found.standard_level], [1.0], "D", color=INK, markersize=5, zorder=4, label="standard"
    )
    axes.axhline(1, color=GREY, linewidth=0.8, linestyle=":", zorder=0)
    make_logarithmic(axes, np.append(amplitudes, found.standard_level))
    axes.set_xlabel(quantity.headed(quantity.title))
    axes.set_ylabel(f"Times as {quantity.adjective} as the standard")
    axes.legend(loc="lower right")
    return figure


class _Ratios(OneStatistic[TaskRatios]):
    name = "ratios"
    trials = TRIALS
    statistics = (RATIOS,)
    question = "How {q.adjective} is each {q.stimulus} relative to a standard?"
    what = "ratio-judgement"
    title = "Ratio judgements"

    def task_name(self, found: TaskRatios, quantity: Quantity) -> str:
        return task_name(
            f"Ratio judgements against {quantity.value(found.standard_level)}", found.task
        )

    def task_answer(self, found: TaskRatios, confidence: float, quantity: Quantity) -> str:
        what = (
            f"{self.task_name(found, quantity)}, "
            f"{counted(found.answers, 'judgement', 'judgements')} by "
            f"{counted(found.participants, 'participant', 'participants')}"
        )
        law = found.power_law
        if isinstance(law, NotComputed):
            return f"{what}: no exponent was computed ({law.reason})."
        return (
            f"{what}: the mean exponent of participants' power functions of {quantity.name} was "
            f"{number(law.exponent)}, {level_of(confidence)} CI {bracketed(law.interval)} (n = "
            f"{law.n}; {law.points} {quantity.levels} above {quantity.value(0)})."
        )

    def task_remarks(self, found: TaskRatios, confidence: float, quantity: Quantity) -> list[str]:
        each = "; ".join(
            f"{quantity.value(one.comparison_level)} {significant(one.ratio)} times"
            + ("" if one.interval is None else f", {bracketed(one.interval, significant)}")
            for one in found.surfaces
        )
        text = (
            f"Judged ratios to the standard (geometric means, {level_of(confidence)} CI of "
            f"participants' mean logarithms): {each}."
        )
        texts = [text]
        if found.catch_ratio is not None:
            texts.append(
                f"The standard itself was judged {significant(found.catch_ratio)} times as "
                f"{quantity.adjective} "
                f"({counted(found.catch_trials, 'catch trial', 'catch trials')}; correct: 1)."
            )
        return texts

    def task_blocks(self, task: TaskRatios, svgs: Svgs, level: float, quantity: Quantity) -> Blocks:
        return [
            *html.figure_if_drawn(
                svgs,
                f"ratios_{task.name}",
                "Ratios to the standard, on logarithmic axes. Pale: individual participants' "
                f"geometric means; blue: the group geometric mean with a t-based {level:g} % "
                "interval, and the power function through them; black: the standard, 1 by "
                "definition.",
                "Geometric mean ratios: "
                + ", ".join(
                    f"{quantity.value(each.comparison_level)}: {each.ratio:.3g}"
                    for each in task.surfaces
                ),
            ),
            _ratio_table(task, quantity),
        ]

    def task_figures(self, task: TaskRatios, trials: pd.DataFrame, quantity: Quantity) -> Figures:
        return {f"ratios_{task.name}": ratios(task, trials[trials["task"] == task.task], quantity)}

    def task_rows(self, task: TaskRatios) -> list[JsonObject]:
        of_task: JsonObject = {"task": task.task, "standard_level": task.standard_level}
        return flat_rows(of_task, task.surfaces)

    def session_tables(self, data: Dataset, _prepared: Prepared | None) -> Iterator[SessionTable]:
        return mean_by_session(
            data, TRIALS, "mean ratio", "natural logarithm", lambda rows: logarithms(rows["ratio"])
        )


ANALYSIS = _Ratios()
