"""Declare ratings on a visual analogue scale, or in categories."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd
from markupsafe import Markup
from matplotlib.figure import Figure

from slipscale.analysis.json_form import JsonObject, renamed
from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.reading.surface_labels import with_unit
from slipscale.analysis.statistics.not_computed import NotComputed, computed, missing
from slipscale.analysis.statistics.statistic import SessionTable
from slipscale.analysis.tasks.declared.flat_table import flat_rows
from slipscale.analysis.tasks.declared.one_statistic import Blocks, Figures, OneStatistic, Svgs
from slipscale.analysis.tasks.declared.session_tables import mean_by_session
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.tasks.ratings import conditions
from slipscale.analysis.tasks.ratings.conditions import CONDITIONS
from slipscale.analysis.tasks.ratings.statistics import RATINGS, TRIALS, TaskRatings, cells
from slipscale.analysis.writing import html
from slipscale.analysis.writing.axes import apart
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import (
    DASH,
    bracketed,
    cell,
    counted,
    joined,
    level_of,
    number,
    p_value,
    unit_number,
)
from slipscale.analysis.writing.points import SIZE, draw_means, draw_people
from slipscale.analysis.writing.task_names import task_name
from slipscale.analysis.writing.verdicts import DIFFERED, page_sentence, verdict
from slipscale.figure_style import GREY, canvas, styled
from slipscale.stimuli.quantity import Quantity

#: Field -> column name, if they differ.
COLUMNS = {"sd": "standard_deviation", "at_left": "at_left_end", "at_right": "at_right_end"}


def _tests(found: TaskRatings, confidence: float, quantity: Quantity) -> str:
    texts = []
    friedman, trend = found.friedman, found.page_trend
    if isinstance(friedman, NotComputed):
        texts.append(f"Whether ratings differ between surfaces was not tested: {friedman.reason}.")
    else:
        verb = verdict(DIFFERED, friedman.p, confidence, friedman.n - 1)
        texts.append(
            f"Ratings {verb} between surfaces (Friedman's test on ranks, χ²({friedman.df}, "
            f"n = {friedman.n}) = {number(friedman.chi2)}, {p_value(friedman.p)}, Kendall's W = "
            f"{unit_number(friedman.kendalls_w)})."
        )
    if trend:
        texts.append(page_sentence("Ratings", trend, confidence, quantity.level, quantity))
    return " ".join([*texts, *_biases(found, confidence)])


def _biases(found: TaskRatings, confidence: float) -> list[str]:
    """Return sentences on the effects of start and end positions, and on catch trials."""
    if found.categories is not None:
        told = (
            "Categories are ordinal: the tests use ranks, but the means treat categories as "
            "equally spaced."
        )
        return [told]
    texts = []
    start = found.start_effect
    if isinstance(start, NotComputed):
        texts.append(
            f"The effect of the mark's starting position was not measured: {start.reason}."
        )
    else:
        low, high = start.interval
        doubt = ", which is compatible with no shift" if low <= 0 <= high else ""
        texts.append(
            "When the mark started 10 points further to the right, ratings were shifted "
            f"{number(10 * abs(start.mean))} points to the "
            f"{'right' if start.mean >= 0 else 'left'} ({level_of(confidence)} CI "
            f"[{number(10 * low)}, {number(10 * high)}]; positive values are to the right){doubt}."
        )
    ends = sum(each.at_left + each.at_right for each in found.surfaces)
    if ends:
        texts.append(
            f"{ends} of {found.answers} ratings were at an end of the line, which biases "
            "means towards the middle. Intervals of means near an end are too narrow (see methods)."
        )
    if found.catch_mean is not None:
        texts.append(
            f"The mean rating of the bare plate was {number(found.catch_mean, 1)} "
            f"({counted(found.catch_trials, 'catch trial', 'catch trials')})."
        )
    texts.append(
        "The line is bounded and has no unit, so ratings can be compared and averaged, "
        "but ratios and exponents are not meaningful."
    )
    return texts


def _rating_table(task: TaskRatings, quantity: Quantity) -> Markup:
    ends = ("At the left end", "At the right end")
    if task.categories is not None:
        ends = ("In the lowest category", "In the highest category")
    rows = [
        [
            each.surface,
            str(each.ratings),
            number(each.mean, 1),
            cell(each.interval, lambda bounds: bracketed(bounds, _one)),
            number(each.sd, 1),
            str(each.at_left),
            str(each.at_right),
        ]
        for each in task.surfaces
    ]
    reasons = dict.fromkeys(one.reason for one in missing(each.interval for each in task.surfaces))
    without = f" Without an interval: {'; '.join(reasons)}." if reasons else ""
    return html.table(
        html.columns("Surface", "Ratings", "Mean", "CI", "SD", *ends, left=1),
        rows,
        f"{_numbers(task)}; {quantity.levels} in "
        f"{quantity.unit}{quantity.behind}. Mean, t-based interval (limited to the range of "
        f"the scale) and standard deviation across participants (one value each).{without}",
    )


def _pair_table(task: TaskRatings) -> Markup:
    rows = [
        [
            pair.from_surface,
            pair.to_surface,
            str(pair.participants),
            cell(pair.difference, lambda mean: number(mean.mean, 1)),
            cell(pair.difference, lambda mean: bracketed(mean.interval, _one)),
            DASH if computed(pair.difference) is None else p_value(pair.p_wilcoxon_holm),
        ]
        for pair in task.pairs
    ]
    return html.table(
        html.columns("From", "To", "n", "Difference", "CI", "p (Wilcoxon, Holm)", left=2),
        rows,
        "Differences between mean ratings, with t-based intervals, and Wilcoxon signed-rank tests "
        "for each pair, Holm-corrected across all pairs in all rating tasks and conditions.",
    )


def _numbers(task: TaskRatings) -> str:
    if task.categories is None:
        return "Positions on the line, from its left end (0) to its right end (100)"
    return f"Categories, from 1 (lowest) to {task.categories}"


def _one(value: float) -> str:
    return number(value, 1)


@styled
def ratings(found: TaskRatings, trials: pd.DataFrame, quantity: Quantity) -> Figure:
    """Plot participants' mean ratings, and means with intervals.

    Parameters
    ----------
    found : TaskRatings
    trials : DataFrame
        Trials of the task, as read by `slipscale.analysis.tasks.ratings.statistics.TRIALS`.
    quantity : Quantity
    """
    figure, axes = canvas(size=SIZE)
    main = trials[~trials["catch"]]
    table = cells(main)
    plain = main.loc[main["level"].notna(), "surface"].astype(str).unique()
    whole = set(table.columns) == set(plain)
    # Textures have no amplitude, so if there are any, all surfaces are drawn side by side.
    places = np.array(
        [float(name) for name in table.columns] if whole else range(len(table.columns)), float
    )
    draw_people(axes, places, table.to_numpy(float))
    draw_means(
        axes,
        places,
        [each.mean for each in found.surfaces],
        [computed(each.interval) for each in found.surfaces],
    )
    low, high = (0, 100) if found.categories is None else (1, found.categories)
    room = 0.03 * (high - low)
    axes.set_ylim(low - room, high + room)
    for end in (low, high):
        axes.axhline(end, color=GREY, linewidth=0.8, linestyle=":", zorder=0)
    axes.set_xticks(places, list(table.columns))
    if whole:
        shown = apart(axes, places)
        axes.set_xticks(shown, [f"{value:g}" for value in shown])
    axes.set_xlabel(quantity.headed(quantity.title) if whole else "Surface")
    axes.set_ylabel("Position on the line (0 to 100)" if low == 0 else f"Category (1 to {high})")
    return figure


class _Ratings(OneStatistic[TaskRatings]):
    name = "ratings"
    trials = TRIALS
    statistics = (RATINGS, CONDITIONS)
    question = "Where on a scale between two words do the {q.stimuli} lie?"
    what = "rating"
    title = "Rating scales"
    heading = "Ratings on a scale"

    def task_name(self, found: TaskRatings, _quantity: Quantity) -> str:
        kind = "Visual analogue scale" if found.categories is None else "Category scale"
        return task_name(kind, found.task)

    def task_answer(self, found: TaskRatings, _confidence: float, quantity: Quantity) -> str:
        numbers = (
            "mean positions on the line from 0 (left) to 100 (right)"
            if found.categories is None
            else f"mean categories, from 1 (lowest) to {found.categories},"
        )
        means = joined(
            [
                f"{number(each.mean, 1)} ({with_unit(each.surface, quantity)})"
                for each in found.surfaces
            ]
        )
        return (
            f"{self.task_name(found, quantity)}, {counted(found.answers, 'rating', 'ratings')} by "
            f"{counted(found.participants, 'participant', 'participants')}: {numbers} were {means}."
        )

    def task_remarks(self, task: TaskRatings, confidence: float, quantity: Quantity) -> list[str]:
        return [_tests(task, confidence, quantity)]

    def task_blocks(
        self, task: TaskRatings, svgs: Svgs, level: float, quantity: Quantity
    ) -> Blocks:
        return [
            *html.figure_if_drawn(
                svgs,
                f"ratings_{task.task}",
                f"{_numbers(task)}. Pale: individual participants' means; blue: the group mean "
                f"with a t-based {level:g} % interval.",
                "Mean ratings: "
                + ", ".join(f"{each.surface}: {number(each.mean, 1)}" for each in task.surfaces),
            ),
            _rating_table(task, quantity),
            _pair_table(task),
        ]

    def task_figures(self, task: TaskRatings, trials: pd.DataFrame, quantity: Quantity) -> Figures:
        own = trials[trials["task"] == task.task]
        return {f"ratings_{task.task}": ratings(task, own, quantity)}

    def task_rows(self, task: TaskRatings) -> list[JsonObject]:
        rows = [
            renamed(each, **COLUMNS) | {"interval": computed(each.interval)}
            for each in task.surfaces
        ]
        return flat_rows({"task": task.task}, rows)

    def sentences(self, analysis: Analysis) -> Mapping[str, list[str]]:
        return {**super().sentences(analysis), conditions.TITLE: conditions.sentences(analysis)}

    def sections(self, analysis: Analysis, svgs: Mapping[str, str]) -> list[ReportSection]:
        return [*super().sections(analysis, svgs), conditions.section(analysis)]

    def session_tables(self, data: Dataset, _prepared: Prepared | None) -> Iterator[SessionTable]:
        return mean_by_session(
            data,
            TRIALS,
            "mean rating",
            "position on the line, 0 to 100, or category",
            lambda rows: rows["rating"].astype(float),
        )


ANALYSIS = _Ratings()
