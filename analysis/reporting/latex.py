"""Format result tables in LaTeX."""

from __future__ import annotations

import math

import pandas as pd

from slipscale.analysis.statistics.not_computed import computed
from slipscale.analysis.statistics.repeated_measures.pairwise import PairComparison
from slipscale.analysis.tasks.estimation.statistics import PAIRWISE
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing.numbers import p_cell

MICRO = r"$\mu$"


def latex_tables(analysis: Analysis) -> dict[str, str]:
    """Return LaTeX tables for a paper, which require the package booktabs."""
    if analysis.prepared is None:
        return {}
    quantity = analysis.dataset.quantity
    unit = _escaped(quantity.short_unit)
    level = _escaped(quantity.title) + (f" ({unit})" if unit else "")
    heads = {
        "level": level,
        "n": "$n$",
        "mean": "Mean",
        "maximum_deviation": "Max.\\ dev.",
        "standard_deviation": "SD",
    }
    table = analysis.table3.rename(columns=heads)
    table[level] = [f"{a:g}" for a in analysis.table3["level"]]
    convention = analysis.dataset.choices.standard_deviation
    rule = analysis.rule.replace("_", r"\_")
    found = {
        "table3": table.to_latex(
            index=False,
            float_format="%.2f",
            label="tab:estimates",
            caption=f"Normalised magnitude estimates (rule: {rule}; SD: {convention}).",
            column_format="rrrrr",
        )
    }
    pairs = analysis.inference[PAIRWISE]
    if pairs:
        rows = pd.DataFrame([_pair(pair, _escaped(quantity.unit)) for pair in pairs])
        found["pairwise"] = rows.to_latex(
            index=False,
            float_format="%.3f",
            na_rep="--",
            label="tab:pairwise",
            caption="Pairwise comparisons of log estimates, Holm-corrected.",
            column_format="rrrrrrrrr",
        )
    return found


def _p(p: float) -> str | None:
    """Format a p-value, with "<" for very small values, or return None for NaN."""
    if math.isnan(p):
        return None
    text = p_cell(p)
    return text.replace("< ", "$<$").replace("> ", "$>$")


def _escaped(text: str) -> str:
    return text.replace("%", r"\%").replace("_", r"\_").replace("µ", MICRO)


def _pair(pair: PairComparison, unit: str) -> dict[str, str | float | None]:
    behind = f" ({unit})" if unit else ""
    logs = computed(pair.logs)
    return {
        f"From{behind}": f"{pair.from_level:g}",
        f"To{behind}": f"{pair.to_level:g}",
        "Ratio": logs.ratio if logs else None,
        "$t$": logs.t if logs else None,
        "df": logs.df if logs else None,
        r"$p_\mathrm{Holm}$": _p(logs.p_holm) if logs else None,
        "$d_z$": logs.d_z if logs else None,
        "$n$": pair.n,
        r"Wilcoxon $p_\mathrm{Holm}$": _p(pair.ranks.p_holm),
    }
