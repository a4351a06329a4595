"""Write the section on the assumptions of the tests."""

from __future__ import annotations

from collections.abc import Mapping

from slipscale.analysis.tasks.estimation.statistics import RM_ANOVA
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import counted, grouped, p_value
from slipscale.analysis.writing.verdicts import reliable


def assumptions(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section on test assumptions and whether the data meet them."""
    section = ReportSection("Assumptions")
    anova, quantity = analysis.inference[RM_ANOVA], analysis.dataset.quantity
    if not anova or "residuals" not in svgs:
        return section
    texts = []
    if anova.mauchly_p is not None:
        level = analysis.dataset.choices.confidence
        verdict = "violated" if reliable(anova.mauchly_p, level) else "not rejected"
        texts.append(
            f"Sphericity was {verdict}: Mauchly's W = {grouped(anova.mauchly_w, 3)}, "
            f"{p_value(anova.mauchly_p)}. The analysis of variance is always corrected for "
            f"non-sphericity: {p_value(anova.p_gg)} with the Greenhouse-Geisser correction (ε = "
            f"{grouped(anova.epsilon_gg, 3)}), and {p_value(anova.p_hf)} with the Huynh-Feldt "
            f"correction (ε = {grouped(anova.epsilon_hf, 3)})."
        )
    elif anova.df1 > 1:
        texts.append(
            "Sphericity cannot be tested because there are fewer participants than "
            f"{quantity.levels}. The Greenhouse-Geisser correction was applied, ε = "
            f"{grouped(anova.epsilon_gg, 3)}."
        )
    if anova.shapiro_p is not None:
        texts.append(
            f"Normality of residuals: Shapiro-Wilk W = {grouped(anova.shapiro_w, 3)}, "
            f"{p_value(anova.shapiro_p)}."
        )
    if anova.n_incomplete:
        texts.append(
            f"{counted(anova.n_incomplete, 'participant was', 'participants were')} "
            "excluded from the analysis of variance because a log estimate is missing for "
            f"at least one {quantity.level}."
        )
    if texts:
        section.gist = texts[:1]
        section.blocks.append(html.bullets(texts[1:]))
    section.blocks.append(
        html.figure(
            svgs["residuals"],
            "Residuals of log estimates. Left: points lie on the line if residuals are normal. "
            f"Right: residuals are evenly spread if variances are equal at every {quantity.level}.",
            "Two charts of residuals: a normal quantile plot, and the spread at each "
            f"{quantity.level}",
        )
    )
    return section
