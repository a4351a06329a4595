"""Scales of slipperiness: from paired comparison and triads, and matches by adjustment."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reporting import apa_scales, html
from slipscale.analysis.reporting.html import ReportSection, TableColumn
from slipscale.analysis.reporting.numbers import DASH, bracketed, number, p_value
from slipscale.analysis.statistics.not_computed import NotComputed

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.result import Analysis
    from slipscale.analysis.statistics.matching import MatchedReference
    from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants
    from slipscale.analysis.statistics.scaling.task_scales import TaskScale


def scales(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section of paired comparison: each task's figure and table."""
    section = _section("Scales of slipperiness", analysis)
    found = analysis.inference.scales
    for task in () if isinstance(found, NotComputed) else found:
        section.blocks.append(html.heading(apa_scales.title(task)))
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
            section.blocks.append(html.paragraph(apa_scales.scale_answer(task), "note"))
        if task.consistency:
            section.blocks.append(_consistency_table(task))
    return section


def matching(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section of matching: figure, and a row a reference."""
    section = _section("Matching", analysis)
    found = analysis.inference.matching
    if isinstance(found, NotComputed):
        return section
    for task in sorted({each.task for each in found}):
        rows = [each for each in found if each.task == task]
        if (svg := svgs.get(f"matching_{task}")) is not None:
            section.blocks.append(
                html.figure(
                    svg,
                    "Matches against references. Small: participants' means; large: means of "
                    "participants, from below (blue, pointing up) and from above (red, pointing "
                    "down).",
                    "Mean matches: "
                    + ", ".join(
                        f"{each.mean_um_pp:.3g} of {each.reference_um_pp:g} µm" for each in rows
                    ),
                )
            )
        section.blocks.append(_matching_table(rows))
    return section


def _section(title: str, analysis: Analysis) -> ReportSection:
    return ReportSection(title, shown="closed" if analysis.prepared is not None else "open")


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
    return html.table(columns, rows, apa_scales.fit(task))


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


def _matching_table(rows: list[MatchedReference]) -> Markup:
    def tested(found: MeanOverParticipants | NotComputed) -> tuple[str, str]:
        if isinstance(found, NotComputed):
            return DASH, DASH
        return f"{number(found.mean, 3)} {bracketed(found.interval, _three)}", p_value(found.p)

    titles = ("Reference (µm)", "Matches", "Mean (µm)", "Bias (µm)", "p", "Own SD (µm)")
    columns = [TableColumn(title=title) for title in (*titles, "Above less below (µm)", "p")]
    return html.table(
        columns,
        [
            [
                number(each.reference_um_pp),
                str(each.matches),
                number(each.mean_um_pp, 3),
                *tested(each.bias_um_pp),
                number(each.variability_um_pp, 3),
                *tested(each.direction_um_pp),
            ]
            for each in rows
        ],
        "Bias: mean match less reference, one value a participant, with Student's interval and "
        "test. Own SD: root mean square of participants' standard deviations within a direction. "
        "The last columns compare matches from above with those from below.",
    )


def _three(value: float) -> str:
    return number(value, 3)
