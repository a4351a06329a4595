"""What the tests assume, and whether the data agree."""

from __future__ import annotations

from typing import TYPE_CHECKING

from analysis.reporting import html
from analysis.reporting.apa import RELIABLE
from analysis.reporting.html import ReportSection
from analysis.reporting.numbers import grouped, p_value
from analysis.statistics.not_computed import NotComputed

if TYPE_CHECKING:
    from collections.abc import Mapping

    from analysis.result import Analysis


def assumptions(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return what the tests assume and whether the data agree."""
    section = ReportSection("Assumptions")
    anova = analysis.inference.rm_anova
    if isinstance(anova, NotComputed) or "residuals" not in svgs:
        return section
    texts = []
    if anova.mauchly_p is not None:
        verdict = "violated" if anova.mauchly_p < RELIABLE else "not rejected"
        texts.append(
            f"Sphericity {verdict}: Mauchly's W = {grouped(anova.mauchly_w, 3)}, "
            f"{p_value(anova.mauchly_p)}; ε = {grouped(anova.epsilon_gg, 3)} "
            f"(Greenhouse-Geisser), {grouped(anova.epsilon_hf, 3)} (Huynh-Feldt); corrected "
            f"{p_value(anova.p_gg)} and {p_value(anova.p_hf)}."
        )
    if anova.shapiro_p is not None:
        texts.append(
            f"Normality of residuals: Shapiro-Wilk W = {grouped(anova.shapiro_w, 3)}, "
            f"{p_value(anova.shapiro_p)}."
        )
    if analysis.prepared is not None and analysis.prepared.zero_sentence:
        texts.append(analysis.prepared.zero_sentence)
    if anova.n_incomplete:
        texts.append(
            f"Participants without a logarithm at some amplitude: {anova.n_incomplete}. They "
            "take no part in tests on logarithms; Friedman's and Wilcoxon's tests keep zeros."
        )
    section.blocks.append(html.bullets(texts))
    section.blocks.append(
        html.figure(
            svgs["residuals"],
            "Residuals of log estimates less participants' and amplitudes' means: left against a "
            "normal distribution (on the line: normal), right at each amplitude (even spread: "
            "equal variances).",
            "Two charts of residuals: quantiles against a normal distribution's, and the spread at "
            "each amplitude",
        )
    )
    return section
