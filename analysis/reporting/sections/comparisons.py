"""Pairwise comparisons, and the tests that could not be computed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from analysis.reporting import html
from analysis.reporting.apa import p_value
from analysis.reporting.html import Column, Section, interval, number

if TYPE_CHECKING:
    from analysis.result import Analysis

TEST_TITLES = {
    "rm_anova": "Repeated-measures ANOVA, log estimates",
    "friedman": "Friedman",
    "page_trend": "Page's ordered trend",
    "linear_trend": "Linear trend, log estimates",
    "pairwise": "Pairwise comparisons",
    "power_law": "Exponent",
    "mixed_model": "Mixed model",
    "growth": "Growth functions",
    "order": "Order and carry-over",
    "reliability": "Test-retest reliability",
}
#: The two parts of "order", each with numbers or a reason.
ORDER_TITLES = {"position": "the trial's position", "carry_over": "the surface before"}


def _bare_p(p: float | None) -> str:
    """Return a p for a column that is headed p: ".023", "< .001"."""
    return p_value(p).removeprefix("p ").removeprefix("= ")


def comparisons(analysis: Analysis) -> Section:
    """Return pairwise comparisons, and which tests could not be computed."""
    section = Section("Comparisons")
    if analysis.prepared is None:
        return section
    pairs = analysis.inference["pairwise"]
    if isinstance(pairs, list):
        level = f"{100 * analysis.dataset.choices.confidence:g} %"
        section.blocks.append(
            html.table(
                [
                    Column(title="From → to", unit="µm, p-p", left=True, whole=True),
                    Column(title="Ratio", unit="of geometric means"),
                    Column(title=f"{level} CI", unit="of the ratio"),
                    Column(title="t"),
                    Column(title="df"),
                    Column(title="p", unit="Holm"),
                    Column(title="d_z"),
                    Column(title=f"{level} CI", unit="of d_z"),
                    Column(title="Up / down", unit="participants"),
                    Column(title="p Wilcoxon", unit="Holm"),
                ],
                [
                    [
                        f"{row['from_um_pp']:g} → {row['to_um_pp']:g}",
                        number(row.get("ratio")),
                        interval(*row.get("ratio_ci", (None, None))),
                        number(row.get("t")),
                        str(row.get("df", "–")),
                        _bare_p(row.get("p_holm")),
                        number(row.get("d_z")),
                        interval(*row.get("d_z_ci", (None, None))),
                        f"{row['up']} / {row['down']}",
                        _bare_p(row.get("p_wilcoxon_holm")),
                    ]
                    for row in pairs
                ],
                f"Paired comparisons of log estimates ({pairs[0]['n']} participants with an "
                "estimate at every amplitude) and Wilcoxon's test on the estimates themselves. "
                "d_z: mean difference over the standard deviation of the differences, with its "
                "exact interval (non-central t).",
            )
        )
    parts = {TEST_TITLES[name]: analysis.inference[name] for name in TEST_TITLES}
    order = analysis.inference["order"]
    parts |= {f"Order: {words}": order.get(name, {}) for name, words in ORDER_TITLES.items()}
    missing = [
        f"{title}: {part['reason']}."
        for title, part in parts.items()
        if isinstance(part, dict) and "reason" in part
    ]
    if missing:
        section.blocks.append(html.heading("Not computed"))
        section.blocks.append(html.bullets(missing, "note"))
    return section
