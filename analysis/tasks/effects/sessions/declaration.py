"""Define how differences between sessions are analysed and reported."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from markupsafe import Markup

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declared.two_way_texts import anova_sentence, anova_table
from slipscale.analysis.tasks.effects.sessions.statistics import (
    SESSIONS,
    SessionEffects,
    SessionMeasure,
)
from slipscale.analysis.tasks.kind import Analysis, TaskAnalysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import (
    DASH,
    bracketed,
    grouped,
    interval,
    joined,
    level_of,
    number,
    p_cell,
    p_value,
    unit_number,
)
from slipscale.analysis.writing.verdicts import CHANGED, reliable, verdict


def sentences(analysis: Analysis) -> list[str]:
    """Return the sentences on sessions, in APA style (7th edition)."""
    found, data = analysis.inference[SESSIONS], analysis.dataset
    if not found:
        return []
    confidence = data.choices.confidence
    texts = [f"Sessions {joined(found.sessions)} were compared."]
    anova = found.anova
    if isinstance(anova, NotComputed):
        if anova.reason != "no magnitude estimates":
            texts.append(
                f"The analysis of variance across sessions was not computed: {anova.reason}."
            )
    else:
        effects = (anova.session, anova.of_level, anova.interaction)
        texts.append(
            anova_sentence(("session", "sessions"), effects, anova.n, confidence, data.quantity)
        )
    return texts + [_of_measure(measure, found.sessions, confidence) for measure in found.measures]


def _of_measure(measure: SessionMeasure, sessions: tuple[str, ...], confidence: float) -> str:
    """Return a sentence on the changes in a measure and its test-retest agreement."""
    name = measure.name[0].upper() + measure.name[1:]
    if isinstance(measure.agreement, NotComputed):
        return f"{name}: sessions were not compared ({measure.agreement.reason})."
    changed = [
        (each.session, each.change, each.p_holm)
        for each in measure.changes
        if each.change and each.p_holm is not None and reliable(each.p_holm, confidence)
    ]
    changes = "; ".join(
        f"to session {session} by {number(change.mean)}, {level_of(confidence)} CI "
        f"{bracketed(change.interval)}, {p_value(p)}"
        for session, change, p in changed
    )
    told = verdict(CHANGED, 1.0, confidence, measure.n - 1)
    if changed:
        told = f"{CHANGED.past} from session {sessions[0]} {changes} (Holm-corrected)"
    icc = measure.agreement
    bounds = "" if icc.interval is None else f" {bracketed(icc.interval, unit_number)}"
    return (
        f"{name} ({measure.unit}, n = {measure.n}) {told}; agreement between single sessions "
        f"was ICC(A,1) = {unit_number(icc.value)}{bounds}."
    )


def _measures(found: SessionEffects, level: str) -> Markup:
    change = ("Change", f"from {found.sessions[0]}, {level} CI")
    tests = (change, ("p", "Holm"), ("ICC(A,1)", f"{level} CI"))
    columns = html.columns("Measure", "Session", "n", "Mean", *tests, left=2)
    rows = [row for measure in found.measures for row in _rows(measure, found.sessions)]
    caption = (
        "One value per participant and session; means and changes across participants who "
        "completed every session. ICC(A,1): absolute agreement between single sessions."
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
            p = p_cell(change.p_holm)
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


class _Sessions(TaskAnalysis):
    name = "sessions"
    statistics = (SESSIONS,)

    def sentences(self, analysis: Analysis) -> Mapping[str, list[str]]:
        return {"Sessions": sentences(analysis)}

    def sections(self, analysis: Analysis, _svgs: Mapping[str, str]) -> list[ReportSection]:
        """Return the section on sessions, which is empty if sessions were not compared."""
        section = ReportSection("Sessions")
        found = analysis.inference[SESSIONS]
        if not found:
            return [section]
        level = level_of(analysis.dataset.choices.confidence)
        if isinstance(found.anova, NotComputed):
            reason = (
                f"The analysis of variance across sessions was not computed: {found.anova.reason}."
            )
            section.blocks.append(html.paragraph(reason, "note"))
        else:
            anova = found.anova
            effects = (anova.session, anova.of_level, anova.interaction)
            section.blocks.append(
                anova_table("session", effects, anova.n, analysis.dataset.quantity)
            )
        if found.measures:
            section.blocks.append(_measures(found, level))
        return [section]


ANALYSIS = _Sessions()
