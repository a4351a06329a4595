"""Write the section on all tests and their correction for multiple testing."""

from __future__ import annotations

from slipscale.analysis.reporting.multiplicity import multiplicity
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import unit_number


def tests_made(analysis: Analysis) -> ReportSection:
    """Return the section with a table of all test families, which is empty if no test was made."""
    section = ReportSection("All tests and their correction")
    choices, quantity = analysis.dataset.choices, analysis.dataset.quantity
    found = multiplicity(analysis.inference, choices.primary, choices.confidence, quantity)
    if not found.tests:
        return section
    level = unit_number(found.level, 3).rstrip("0")
    below = sum(family.below for family in found.families)
    over_all = sum(family.below_over_all for family in found.families)
    corrected = f"{over_all} if all tests are corrected as one family"
    section.gist = [f"Tests significant at {level}: {below} of {found.tests}, or {corrected}."]
    section.blocks.append(
        html.table(
            html.columns(
                "Family",
                "Analysis",
                "Corrected",
                "Tests",
                (f"p < {level}", "corrected"),
                (f"p < {level}", "overall"),
                left=3,
            ),
            [
                [
                    family.name[:1].upper() + family.name[1:],
                    "primary" if family.primary else "secondary",
                    "Holm" if family.corrected else "no",
                    str(family.tests),
                    str(family.below),
                    str(family.below_over_all),
                ]
                for family in found.families
            ],
            "All tests with a p-value. The last column shows how many tests remain significant if "
            "Holm's correction is applied to the whole report. Checks of assumptions and goodness "
            "of fit are not counted.",
        )
    )
    return section
