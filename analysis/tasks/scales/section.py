"""Write the section on scales from paired comparison and triads."""

from __future__ import annotations

from statistics import median
from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed, all_computed, computed, fold
from slipscale.analysis.tasks.scales import sentences
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import TableColumn
from slipscale.analysis.writing.numbers import DASH, bracketed, number, p_value

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.scales.difference_scaling import DifferenceScale
    from slipscale.analysis.tasks.scales.paired_comparison_scale import ComparisonScale
    from slipscale.analysis.tasks.scales.statistics import TaskScale
    from slipscale.analysis.tasks.scales.transitivity import Consistency
    from slipscale.stimuli.quantity import Quantity


def blocks(
    task: TaskScale, svgs: Mapping[str, str], level: float, quantity: Quantity
) -> list[Markup]:
    """Return the blocks of one task: its figures and tables."""
    values = bool(task.consistency) or computed(task.differences) is not None
    return [
        html.heading(sentences.title(task)),
        *html.figure_if_drawn(
            svgs,
            f"scale_{task.task}",
            f"Scale values with {level:g} % intervals"
            + (
                ", which account for correlated answers of a participant."
                if task.consistency
                else " (bootstrap); the first and last surface are 0 and 1 by definition."
            ),
            f"Scale values of {', '.join(task.surfaces)}",
        ),
        _scale_table(task)
        if values
        else html.paragraph(sentences.scale_answer(task, quantity), "note"),
        *([_consistency_table(task)] if task.consistency else []),
    ]


def _scale_table(task: TaskScale) -> Markup:
    scales: dict[str, ComparisonScale | DifferenceScale | NotComputed] = {
        "Bradley-Terry": task.bradley_terry,
        "Thurstone V": task.thurstone,
        "Difference scale": task.differences,
    }
    columns = [TableColumn(title="Surface", left=True)]
    cells: list[list[str]] = []
    if task.chosen:
        columns.append(TableColumn(title="Chosen"))
        counts = zip(task.chosen, task.compared, strict=True)
        cells.append([f"{chosen}/{compared}" for chosen, compared in counts])
    for title, found in scales.items():
        if found:
            columns += [TableColumn(title=title), TableColumn(title="CI")]
            cells.append([number(value) for value in found.values])
            cells.append([bracketed(interval) for interval in found.intervals])
    rows = [
        [name, *(column[place] for column in cells)] for place, name in enumerate(task.surfaces)
    ]
    return html.table(columns, rows, sentences.fit(task))


def _consistency_table(task: TaskScale) -> Markup:
    zetas = [each.zeta for each in all_computed(task.consistency.values())]
    rows = [
        [who, *fold(each, _counts, lambda reason: [DASH, DASH, reason])]
        for who, each in task.consistency.items()
    ]
    titles = ("Circular triads", "Consistence ζ", "By chance")
    columns = [TableColumn(title="Participant", left=True), *(TableColumn(title=t) for t in titles)]
    caption = (
        "Circular triads (A over B, B over C, C over A; ties count half each way), Kendall's "
        "coefficient of consistence, and the probability of so few if choices were random."
    )
    summary = "Consistency of each participant"
    if zetas:
        summary += (
            f": ζ from {number(min(zetas))} to {number(max(zetas))}, median "
            f"{number(median(zetas))} (1: no circular triads)"
        )
    return html.details(summary, [html.table(columns, rows, caption)])


def _counts(found: Consistency) -> list[str]:
    return [f"{found.circular_triads:g}/{found.triads}", number(found.zeta), p_value(found.p)]
