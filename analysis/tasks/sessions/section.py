"""Write the section on sessions: their means, changes, and test-retest agreement."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declared.two_way_texts import anova_table
from slipscale.analysis.tasks.sessions.statistics import SESSIONS
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import (
    DASH,
    grouped,
    interval,
    level_of,
    p_value,
    unit_number,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.kind import Analysis
    from slipscale.analysis.tasks.sessions.statistics import SessionEffects, SessionMeasure


def sessions(analysis: Analysis, _svgs: Mapping[str, str]) -> ReportSection:
    """Return the section on sessions; empty for a single session or if not requested."""
    section = ReportSection("Sessions")
    found = analysis.inference[SESSIONS]
    if not found:
        return section
    level = level_of(analysis.dataset.choices.confidence)
    if isinstance(found.anova, NotComputed):
        reason = f"Analysis of variance over sessions: {found.anova.reason}."
        section.blocks.append(html.paragraph(reason, "note"))
    else:
        anova = found.anova
        effects = (anova.session, anova.amplitude, anova.interaction)
        section.blocks.append(anova_table("session", effects, anova.n, analysis.dataset.quantity))
    if found.measures:
        section.blocks.append(_measures(found, level))
    return section


def _measures(found: SessionEffects, level: str) -> Markup:
    columns = [
        TableColumn(title="Measure", left=True),
        TableColumn(title="Session", left=True),
        TableColumn(title="n"),
        TableColumn(title="Mean"),
        TableColumn(title="Change", unit=f"from {found.sessions[0]}, {level} CI"),
        TableColumn(title="p", unit="Holm"),
        TableColumn(title="ICC(A,1)", unit=f"{level} CI"),
    ]
    rows = [row for measure in found.measures for row in _rows(measure, found.sessions)]
    caption = (
        "One number per participant and session; means and changes across participants with "
        "every session. ICC(A,1): absolute agreement of single sessions."
    )
    return html.table(columns, rows, caption)


def _rows(measure: SessionMeasure, labels: tuple[str, ...]) -> Iterator[list[str]]:
    icc = measure.agreement
    agreed = DASH
    if icc:
        bounds = "" if icc.interval is None else f" {interval(*icc.interval)}"
        agreed = f"{unit_number(icc.value)}{bounds}"
    changes = {each.session: each for each in measure.changes}
    for place, label in enumerate(labels):
        change = changes.get(label)
        moved, p = DASH, DASH
        if change is not None and change.change:
            moved = f"{grouped(change.change.mean, 3)} {interval(*change.change.interval)}"
        if change is not None and change.p_holm is not None:
            p = p_value(change.p_holm).removeprefix("p ").removeprefix("= ")
        first = place == 0
        yield [
            f"{measure.name} ({measure.unit})" if first else "",
            label,
            str(measure.n),
            grouped(measure.means[place], 3) if measure.means else DASH,
            moved,
            p,
            agreed if first else "",
        ]
