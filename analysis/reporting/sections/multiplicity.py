"""Write the section on the number of tests in the report, and their correction."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reporting.multiplicity import multiplicity
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import unit_number

if TYPE_CHECKING:
    from slipscale.analysis.tasks.kind import Analysis


def tests_made(analysis: Analysis) -> ReportSection:
    """Return every family of tests in one table; empty if nothing was tested."""
    section = ReportSection("All tests, and their correction")
    choices, quantity = analysis.dataset.choices, analysis.dataset.quantity
    found = multiplicity(analysis.inference, choices.primary, choices.confidence, quantity)
    if not found.tests:
        return section
    level = unit_number(found.level, 3).rstrip("0")
    section.blocks.append(
        html.table(
            [
                TableColumn(title="Family", left=True),
                TableColumn(title="Analysis", left=True),
                TableColumn(title="Correction", left=True),
                TableColumn(title="Tests"),
                TableColumn(title=f"p < {level}", unit="as corrected"),
                TableColumn(title=f"p < {level}", unit="Holm over all"),
            ],
            [
                [
                    family.name[:1].upper() + family.name[1:],
                    "primary" if family.primary else "secondary",
                    "Holm, within the family" if family.corrected else "none",
                    str(family.tests),
                    str(family.below),
                    str(family.below_over_all),
                ]
                for family in found.families
            ],
            f"{found.tests} tests are judged in this report at {level}. The primary analysis "
            "answers the question; each other family stands for itself, and is corrected within, "
            "not for the others. The last column says how many tests remain if all of the report "
            "were one family. Exponents, growth functions, reliability, shares of “yes” and d′ are "
            "estimates with intervals: nothing is tested there. Checks of assumptions and of fit "
            "decide nothing, and are not counted.",
        )
    )
    return section
