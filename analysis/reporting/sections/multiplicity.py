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
    section = ReportSection("All tests and their correction")
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
            f"{found.tests} tests in this report are judged at {level}. The primary analysis "
            f"answers the question; each other family is corrected separately. The last column "
            f"shows how many tests stay significant if the whole report is corrected as one "
            f"family. Exponents, growth functions, reliability, shares of “yes” and d′ are "
            f"estimates with intervals, not tests. Assumption and fit checks are descriptive and "
            f"not counted.",
        )
    )
    return section
