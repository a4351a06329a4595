"""Write the table and the sentence for a two-way analysis of variance."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.writing import html
from slipscale.analysis.writing.numbers import (
    grouped,
    number,
    p_cell,
    p_value,
    unit_number,
)
from slipscale.analysis.writing.verdicts import DIFFERED, verdict

if TYPE_CHECKING:
    from markupsafe import Markup

    from slipscale.analysis.statistics.repeated_measures.two_way import Effect
    from slipscale.stimuli.quantity import Quantity

    Effects = tuple[Effect, Effect, Effect]


def anova_table(factor: str, effects: Effects, n: int, quantity: Quantity) -> Markup:
    """Return the table with the effects of a factor, the level and their interaction."""
    names = (factor, quantity.name, f"{factor} x {quantity.name}")
    rows = [
        [
            name,
            grouped(effect.F),
            grouped(effect.df1),
            grouped(effect.df2),
            p_cell(effect.p),
            unit_number(effect.eta2_partial),
        ]
        for name, effect in zip(names, effects, strict=True)
    ]
    return html.table(
        html.columns("Effect", "F", "df 1", "df 2", "p", "partial η²", left=1),
        rows,
        f"Analysis of variance of the mean log estimates of {n} participants, with {factor} and "
        f"{quantity.name} as within-participant factors and Greenhouse–Geisser-corrected degrees "
        "of freedom.",
    )


def anova_sentence(
    names: tuple[str, str], effects: Effects, n: int, confidence: float, quantity: Quantity
) -> str:
    """Return a sentence on the effect of a factor and its interaction with the level.

    Parameters
    ----------
    names : tuple of str
        Name of the factor and plural name of its levels, such as ("session", "sessions").
    """
    factor, levels = names
    means, growth = (
        verdict(DIFFERED, effects[place].p, confidence, effects[place].df2) for place in (0, 2)
    )
    return (
        f"In an analysis of variance of log estimates with {factor} and {quantity.name} as "
        f"within-participant factors (n = {n}, Greenhouse–Geisser-corrected), estimates "
        f"{means} between {levels}, {effect_text(effects[0])}. The effect of "
        f"{quantity.name} {growth} between {levels} (interaction), "
        f"{effect_text(effects[2])}."
    )


def effect_text(found: Effect) -> str:
    """Format an effect as F with its degrees of freedom, p and partial eta squared."""
    return (
        f"F({_degrees(found.df1)}, {_degrees(found.df2)}) = {number(found.F)}, "
        f"{p_value(found.p)}, partial η² = {unit_number(found.eta2_partial)}"
    )


def _degrees(df: float) -> str:
    return number(df, 0 if df == round(df) else 2)
