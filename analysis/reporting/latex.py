"""Tables for a paper, in LaTeX."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import pandas as pd

from slipscale.analysis.reading.own_words import in_own_words
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.estimation.statistics import PAIRWISE
from slipscale.analysis.writing.numbers import p_value

MICRO = r"$\mu$"

if TYPE_CHECKING:
    from slipscale.analysis.reading.quantity import Quantity
    from slipscale.analysis.result import Analysis
    from slipscale.analysis.statistics.pairwise import PairComparison


def latex_tables(analysis: Analysis) -> dict[str, str]:
    """Return the tables for a paper, in LaTeX with booktabs."""
    if analysis.prepared is None:
        return {}
    heads = {
        "amplitude_um_pp": r"Amplitude ($\mu$m, p-p)",
        "n": "$n$",
        "mean": "Mean",
        "maximum_deviation": "Max.\\ dev.",
        "standard_deviation": "SD",
    }
    table = analysis.table3.rename(columns=heads)
    table[heads["amplitude_um_pp"]] = [f"{a:g}" for a in analysis.table3["amplitude_um_pp"]]
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
    if not isinstance(pairs, NotComputed):
        rows = pd.DataFrame([_pair(pair) for pair in pairs])
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
    """Return a p as it is printed: never as 0.000."""
    if math.isnan(p):
        return None
    text = p_value(p).removeprefix("p ").removeprefix("= ")
    return text.replace("< ", "$<$").replace("> ", "$>$")


def _pair(pair: PairComparison) -> dict[str, str | float | None]:
    logs = None if isinstance(pair.logs, NotComputed) else pair.logs
    return {
        r"From ($\mu$m)": f"{pair.from_um_pp:g}",
        r"To ($\mu$m)": f"{pair.to_um_pp:g}",
        "Ratio": logs.ratio if logs else None,
        "$t$": logs.t if logs else None,
        "df": logs.df if logs else None,
        r"$p_\mathrm{Holm}$": _p(logs.p_holm) if logs else None,
        "$d_z$": logs.d_z if logs else None,
        "$n$": pair.n,
        r"Wilcoxon $p_\mathrm{Holm}$": _p(pair.ranks.p_holm),
    }


def in_own_latex(text: str, quantity: Quantity) -> str:
    """Return a table as it reads for a quantity."""
    if quantity.of_plate:
        return text
    plain = quantity.unit.replace("%", r"\%").replace("_", r"\_")
    written = in_own_words(text.replace(MICRO, "µ"), replace(quantity, unit=plain))
    return written.replace("µ", MICRO)
