"""Write the section on the assumptions of the tests, and whether the data agree."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.tasks.estimation.statistics import RM_ANOVA
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import grouped, p_value, reliable

if TYPE_CHECKING:
    from collections.abc import Mapping

    from slipscale.analysis.tasks.kind import Analysis


def assumptions(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the assumptions of the tests, and whether the data agree."""
    section = ReportSection("Assumptions")
    anova, quantity = analysis.inference[RM_ANOVA], analysis.dataset.quantity
    if not anova or "residuals" not in svgs:
        return section
    texts = []
    if anova.mauchly_p is not None:
        level = analysis.dataset.choices.confidence
        verdict = "violated" if reliable(anova.mauchly_p, level) else "not rejected"
        texts.append(
            f"Sphericity {verdict}: Mauchly's W = {grouped(anova.mauchly_w, 3)}, "
            f"{p_value(anova.mauchly_p)}. The Greenhouse-Geisser correction is always used, "
            f"because this test has little power with a dozen people: ε = "
            f"{grouped(anova.epsilon_gg, 3)}, {p_value(anova.p_gg)} (Huynh-Feldt: "
            f"{grouped(anova.epsilon_hf, 3)}, {p_value(anova.p_hf)})."
        )
    elif anova.df1 > 1:
        texts.append(
            f"Sphericity cannot be tested: fewer participants than {quantity.levels}. The "
            f"Greenhouse-Geisser correction is used, ε = {grouped(anova.epsilon_gg, 3)}."
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
            f"Participants without a logarithm at some {quantity.level}: {anova.n_incomplete}. "
            "They are excluded from tests on logarithms; Friedman's and Wilcoxon's tests include "
            "zeros."
        )
    section.blocks.append(html.bullets(texts))
    section.blocks.append(
        html.figure(
            svgs["residuals"],
            f"Residuals of log estimates less participants' and {quantity.levels}' means: left "
            f"against a normal distribution (points on the line: normal), right at each "
            f"{quantity.level} "
            "(even spread: equal variances).",
            "Two charts of residuals: quantiles against a normal distribution's, and the spread "
            "at "
            f"each {quantity.level}",
        )
    )
    return section
