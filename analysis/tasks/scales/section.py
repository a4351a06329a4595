"""The section on scales from paired comparison and triads."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declaring import section_of
from slipscale.analysis.tasks.scales import sentences
from slipscale.analysis.tasks.scales.statistics import SCALES
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import DASH, bracketed, number, p_value

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.kind import Analysis
    from slipscale.analysis.tasks.scales.statistics import TaskScale


def scales(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section of paired comparison: each task's figure and table."""
    section = section_of("Scales of slipperiness", analysis)
    found = analysis.inference[SCALES]
    for task in () if isinstance(found, NotComputed) else found:
        section.blocks.append(html.heading(sentences.title(task)))
        if (svg := svgs.get(f"scale_{task.task}")) is not None:
            level = 100 * analysis.dataset.choices.confidence
            section.blocks.append(
                html.figure(
                    svg,
                    f"Scale values with {level:g} % intervals"
                    + (
                        ", which allow for answers of one participant being alike."
                        if task.consistency
                        else " (bootstrap); the first and last surface are 0 and 1 by definition."
                    ),
                    f"Scale values of {', '.join(task.surfaces)}",
                )
            )
        if task.consistency or not isinstance(task.differences, NotComputed):
            section.blocks.append(_scale_table(task))
        else:
            section.blocks.append(html.paragraph(sentences.scale_answer(task), "note"))
        if task.consistency:
            section.blocks.append(_consistency_table(task))
    return section


def _scale_table(task: TaskScale) -> Markup:
    bradley_terry, thurstone, triads = task.bradley_terry, task.thurstone, task.differences
    columns = [TableColumn(title="Surface", left=True)]
    cells: list[list[str]] = []
    if task.chosen:
        columns.append(TableColumn(title="Chosen"))
        counts = zip(task.chosen, task.compared, strict=True)
        cells.append([f"{chosen} of {compared}" for chosen, compared in counts])
    for title, found in (("Bradley-Terry", bradley_terry), ("Thurstone V", thurstone)):
        if not isinstance(found, NotComputed):
            columns += [TableColumn(title=title), TableColumn(title="CI")]
            cells.append([number(value) for value in found.values])
            cells.append([bracketed(interval) for interval in found.intervals])
    if not isinstance(triads, NotComputed):
        columns += [TableColumn(title="Difference scale"), TableColumn(title="CI")]
        cells.append([number(value) for value in triads.values])
        cells.append([DASH if each is None else bracketed(each) for each in triads.intervals])
    rows = [
        [name, *(column[place] for column in cells)] for place, name in enumerate(task.surfaces)
    ]
    return html.table(columns, rows, sentences.fit(task))


def _consistency_table(task: TaskScale) -> Markup:
    rows = [
        [who, DASH, DASH, each.reason]
        if isinstance(each, NotComputed)
        else [who, f"{each.circular_triads} of {each.triads}", number(each.zeta), p_value(each.p)]
        for who, each in task.consistency.items()
    ]
    titles = ("Circular triads", "Consistence ζ", "By chance")
    columns = [TableColumn(title="Participant", left=True), *(TableColumn(title=t) for t in titles)]
    return html.table(
        columns,
        rows,
        "Circular triads of each participant (A over B, B over C, C over A), Kendall's coefficient "
        "of consistence, and the probability of so few if every choice were a toss of a coin.",
    )


def _three(value: float) -> str:
    return number(value, 3)
