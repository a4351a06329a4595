"""Write the section on ratings on a visual analogue scale, or in categories."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import computed
from slipscale.analysis.tasks.ratings import sentences as words
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import TableColumn
from slipscale.analysis.writing.numbers import DASH, bracketed, cell, number, p_value

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.ratings.statistics import TaskRatings
    from slipscale.stimuli.quantity import Quantity


EXTREMES = ("In the lowest", "In the highest")


def blocks(
    task: TaskRatings, svgs: Mapping[str, str], level: float, quantity: Quantity
) -> list[Markup]:
    """Return the blocks of one task: its figures and tables."""
    return [
        html.heading(words.rating_title(task)),
        *html.figure_if_drawn(
            svgs,
            f"ratings_{task.task}",
            f"{_numbers(task)}. Pale: each participant's means; blue: their mean with a t-based "
            f"{level:g} % interval.",
            "Mean ratings: "
            + ", ".join(f"{each.surface}: {number(each.mean, 1)}" for each in task.surfaces),
        ),
        _rating_table(task, quantity),
        _pair_table(task),
    ]


def _rating_table(task: TaskRatings, quantity: Quantity) -> Markup:
    ends = ("At the left end", "At the right end") if task.categories is None else EXTREMES
    titles = ("Ratings", "Mean", "CI", "SD", *ends)
    columns = [TableColumn(title="Surface", left=True), *(TableColumn(title=t) for t in titles)]
    rows = [
        [
            each.surface,
            str(each.ratings),
            number(each.mean, 1),
            bracketed(each.interval, _one),
            number(each.sd, 1),
            str(each.at_left),
            str(each.at_right),
        ]
        for each in task.surfaces
    ]
    return html.table(
        columns,
        rows,
        f"{_numbers(task)}; {quantity.levels} in "
        f"{quantity.unit}{quantity.behind}. Mean, t-based interval and standard deviation "
        "across participants (one value each).",
    )


def _pair_table(task: TaskRatings) -> Markup:
    columns = [
        TableColumn(title="From", left=True),
        TableColumn(title="To", left=True),
        *(TableColumn(title=title) for title in ("n", "Difference", "CI", "p (Wilcoxon, Holm)")),
    ]
    rows = []
    for pair in task.pairs:
        found = pair.difference
        rows.append(
            [
                pair.from_surface,
                pair.to_surface,
                str(pair.participants),
                cell(found, lambda mean: number(mean.mean, 1)),
                cell(found, lambda mean: bracketed(mean.interval, _one)),
                DASH if computed(found) is None else p_value(pair.p_wilcoxon_holm),
            ]
        )
    return html.table(
        columns,
        rows,
        "Differences of mean ratings, with t-based intervals; Wilcoxon's signed-rank test of each "
        "pair, Holm-corrected over all pairs of the task.",
    )


def _numbers(task: TaskRatings) -> str:
    if task.categories is None:
        return "Places on the line, from its left end (0) to its right (100)"
    return f"Categories, from 1 (lowest) to {task.categories}"


def _one(value: float) -> str:
    return number(value, 1)
