"""Write the section on test assumptions and whether the data meet them."""

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
    """Return the assumptions of the tests, and whether the data meet them."""
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
            f"{p_value(anova.mauchly_p)}. The analysis of variance is always corrected: "
            f"Greenhouse-Geisser ε = {grouped(anova.epsilon_gg, 3)}, {p_value(anova.p_gg)} "
            f"(Huynh-Feldt: {grouped(anova.epsilon_hf, 3)}, {p_value(anova.p_hf)})."
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
    if anova.n_incomplete:
        texts.append(
            f"Participants without a log estimate at some {quantity.level}, excluded from the "
            f"analysis of variance: {anova.n_incomplete}."
        )
    if texts:
        section.gist, *rest = texts
        section.blocks.append(html.bullets(rest))
    section.blocks.append(
        html.figure(
            svgs["residuals"],
            f"Residuals of log estimates. Left: on the line if normal. Right: evenly spread if "
            f"variances are equal at each {quantity.level}.",
            "Two charts of residuals: quantiles against a normal distribution's, and the spread "
            f"at each {quantity.level}",
        )
    )
    return section
