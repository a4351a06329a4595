"""Write the sentences on sessions, in APA style (7th edition)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.cells import listed
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.writing.numbers import (
    bracketed,
    level_of,
    number,
    p_value,
    reliable,
    unit_number,
)

if TYPE_CHECKING:
    from slipscale.analysis.tasks.groups.statistics import Effect
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
        means = "differed" if reliable(anova.session.p, confidence) else "did not differ reliably"
        growth = (
            "differed" if reliable(anova.interaction.p, confidence) else "did not differ reliably"
        )
        texts.append(
            f"In an analysis of variance of log estimates with session and {quantity.name} within "
            f"participants (n = {anova.n}, Greenhouse-Geisser), sessions {means}, "
            f"{_statistics(anova.session)}; the effect of {quantity.name} {growth} between "
            f"sessions (interaction), {_statistics(anova.interaction)}."
        )
    return texts + [_of_measure(measure, found.sessions, confidence) for measure in found.measures]


def _statistics(found: Effect) -> str:
    return (
        f"F({found.df1:.3g}, {found.df2:.4g}) = {number(found.F)}, {p_value(found.p)}, partial "
        f"η² = {unit_number(found.eta2_partial)}"
    )


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
