"""What the tests assume, and how the data looks by it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from analysis.reporting import html
from analysis.reporting.apa import RELIABLE, p_value
from analysis.reporting.html import Section, number

if TYPE_CHECKING:
    from collections.abc import Mapping

    from analysis.result import Analysis


def assumptions(analysis: Analysis, svgs: Mapping[str, str]) -> Section:
    """Return what the tests assume and how the data looks by it."""
    section = Section("Assumptions")
    anova = analysis.inference["rm_anova"]
    if "residuals" not in svgs:
        return section
    texts = []
    if anova["mauchly_p"] is not None:
        verdict = "violated" if anova["mauchly_p"] < RELIABLE else "not rejected"
        texts.append(
            f"Sphericity {verdict}: Mauchly's W = {number(anova['mauchly_w'], 3)}, "
            f"{p_value(anova['mauchly_p'])}; ε = {number(anova['epsilon_gg'], 3)} "
            f"(Greenhouse-Geisser), {number(anova['epsilon_hf'], 3)} (Huynh-Feldt); corrected "
            f"{p_value(anova['p_gg'])} and {p_value(anova['p_hf'])}."
        )
    if "shapiro_p" in anova:
        texts.append(
            f"Normality of residuals: Shapiro-Wilk W = {number(anova['shapiro_w'], 3)}, "
            f"{p_value(anova['shapiro_p'])}."
        )
    if analysis.prepared is not None and analysis.prepared.zero_sentence:
        texts.append(analysis.prepared.zero_sentence)
    if anova["n_incomplete"]:
        texts.append(
            f"Participants without a logarithm at some amplitude: {anova['n_incomplete']}. They "
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
