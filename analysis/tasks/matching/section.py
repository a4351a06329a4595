"""The section on matching."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declaring import section_of
from slipscale.analysis.tasks.matching.statistics import MATCHING
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import DASH, bracketed, number, p_value

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants
    from slipscale.analysis.tasks.kind import Analysis
    from slipscale.analysis.tasks.matching.statistics import MatchedReference
from slipscale.analysis.tasks.scales.section import _three


def matching(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section of matching: figure, and a row a reference."""
    section = section_of("Matching", analysis)
    found = analysis.inference[MATCHING]
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
