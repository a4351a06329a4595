"""Write the section on whether the exponent of magnitude estimates fits the Weber fraction."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.exponent_and_weber import sentences
from slipscale.analysis.tasks.exponent_and_weber.statistics import EXPONENT_AND_WEBER
from slipscale.analysis.tasks.thresholds.statistics import THRESHOLDS
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection

if TYPE_CHECKING:
    from collections.abc import Mapping

    from slipscale.analysis.tasks.kind import Analysis


def exponent_and_weber(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section; if a study has both measures but no comparison, it states why."""
    section = ReportSection("Exponent and Weber fraction")
    found = analysis.inference[EXPONENT_AND_WEBER]
    if isinstance(found, NotComputed):
        # A study with only one of the two has nothing to report.
        if analysis.prepared is not None and not isinstance(
            analysis.inference[THRESHOLDS], NotComputed
        ):
            section.blocks.append(html.paragraph(f"Not compared: {found.reason}.", "note"))
        return section
    confidence, quantity = analysis.dataset.choices.confidence, analysis.dataset.quantity
    section.gist = " ".join(sentences.sentences(found, confidence, quantity))
    for one in found:
        if (svg := svgs.get(f"exponent_and_weber_{one.task}")) is not None:
            section.blocks.append(
                html.figure(
                    svg,
                    "Each participant's exponent against their Weber fraction, and the means "
                    f"with {100 * confidence:g} % intervals. Line: Ekman's law with 0.03; "
                    "band: 0.025 to 0.035, as found for nine continua (Teghtsoonian 1971).",
                    f"Exponents and Weber fractions of {len(one.participants)} participants",
                )
            )
    section.blocks.append(
        html.paragraph(
            "The law describes a whole sense and its just noticeable differences, but the "
            f"exponent describes the {quantity.levels} rated here, and falls if they span a "
            "wide range.",
            "note",
        )
    )
    return section
