"""Write the sentences on sessions, in APA style (7th edition)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.cells import listed
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declared.two_way_texts import anova_sentence
from slipscale.analysis.writing.numbers import (
    bracketed,
    level_of,
    number,
    p_value,
    reliable,
    unit_number,
)

if TYPE_CHECKING:
    from slipscale.analysis.tasks.sessions.statistics import SessionEffects, SessionMeasure
    from slipscale.stimuli.quantity import Quantity


def session_sentences(
    found: SessionEffects | NotComputed, confidence: float, quantity: Quantity
) -> list[str]:
    """Return the sentences on sessions; empty for a single session."""
    if not found:
        return []
    texts = [f"Sessions compared: {listed(found.sessions)}."]
    anova = found.anova
    if isinstance(anova, NotComputed):
        if anova.reason != "no magnitude estimates":
            texts.append(
                f"The analysis of variance over sessions was not computed: {anova.reason}."
            )
    else:
        effects = (anova.session, anova.amplitude, anova.interaction)
        texts.append(
            anova_sentence(("session", "sessions"), effects, anova.n, confidence, quantity)
        )
    return texts + [_of_measure(measure, found.sessions, confidence) for measure in found.measures]


def _of_measure(measure: SessionMeasure, sessions: tuple[str, ...], confidence: float) -> str:
    """Return whether a measure changed, and its test-retest agreement."""
    name = measure.name[0].upper() + measure.name[1:]
    if isinstance(measure.agreement, NotComputed):
        return f"{name}: sessions were not compared ({measure.agreement.reason})."
    changed = [
        (each.session, each.change, each.p_holm)
        for each in measure.changes
        if each.change and each.p_holm is not None and reliable(each.p_holm, confidence)
    ]
    said = "; ".join(
        f"session {session} by {number(change.mean)}, {level_of(confidence)} CI "
        f"{bracketed(change.interval)}, {p_value(p)}"
        for session, change, p in changed
    )
    told = f"changed from session {sessions[0]} (Holm-corrected): {said}" if changed else (
        "did not change reliably"
    )  # fmt: skip
    icc = measure.agreement
    bounds = "" if icc.interval is None else f" {bracketed(icc.interval, unit_number)}"
    return (
        f"{name} ({measure.unit}, n = {measure.n}) {told}; agreement between single sessions was "
        f"ICC(A,1) = {unit_number(icc.value)}{bounds}."
    )
