"""Write the section that compares the analysis with its frozen plan."""

from __future__ import annotations

from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing import html


def plan(analysis: Analysis) -> html.ReportSection:
    """Return the section on deviations from the plan, which is empty if there is no plan."""
    section = html.ReportSection("Deviations from the plan", shown="always")
    check = analysis.plan
    if check is None:
        return section
    section.blocks.append(html.paragraph(summary(analysis)))
    if check.deviations:
        columns = [
            html.TableColumn(title="What", left=True, whole=True),
            html.TableColumn(title="Deviation", left=True),
        ]
        rows = [(each.kind, each.what) for each in check.deviations]
        section.blocks.append(html.table(columns, rows, "All deviations from the frozen plan."))
    return section


def summary(analysis: Analysis) -> str:
    """Summarise the deviations from the plan, and state what the comparison cannot detect."""
    check = analysis.plan
    if check is None:
        return ""
    number = len(check.deviations)
    counted = {0: "There are no deviations", 1: "There is 1 deviation"}
    return (
        f"{counted.get(number, f'There are {number} deviations')} from the plan {check.plan}, "
        f"frozen at {check.frozen_utc} (SHA-256 {check.digest}). The comparison does "
        "not detect journals or plans whose hashes were recomputed after editing."
    )
