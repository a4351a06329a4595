"""Write the sentences on factors, in APA style (7th edition)."""

from __future__ import annotations

from math import exp
from typing import TYPE_CHECKING

from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declared.two_way_texts import anova_sentence
from slipscale.analysis.writing.numbers import bracketed, level_of, number, p_value

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from slipscale.analysis.tasks.factors.statistics import ConditionChange, FactorEffects
    from slipscale.stimuli.quantity import Quantity

    Change = MeanOverParticipants | NotComputed


def factor_sentences(
    found: tuple[FactorEffects, ...] | NotComputed, confidence: float, quantity: Quantity
) -> list[str]:
    """Return the sentences on every factor; empty without factors."""
    texts = []
    for each in found or ():
        anova = each.anova
        if isinstance(anova, NotComputed):
            texts.append(
                f"The analysis of variance with {each.factor} was not computed: {anova.reason}."
            )
        else:
            names = (each.factor, f"conditions of {each.factor}")
            texts.append(anova_sentence(names, anova.effects, anova.n, confidence, quantity))
        first = each.conditions[0].condition
        for change in each.changes:
            parts = "; ".join(_parts(change, confidence))
            if parts:
                texts.append(f"{each.factor} {change.condition} against {first}: {parts}.")
    return texts


def _parts(change: ConditionChange, confidence: float) -> Iterator[str]:
    level = level_of(confidence)

    def ratio(value: float) -> str:
        return number(exp(value))

    parts: tuple[tuple[str, Change, float | None, Callable[[float], str]], ...] = (
        ("geometric means in a ratio of", change.log_ratio, change.log_ratio_p_holm, ratio),
        ("exponents differing by", change.exponent, change.exponent_p_holm, number),
    )
    for words, part, p, write in parts:
        if isinstance(part, MeanOverParticipants) and p is not None:
            yield (
                f"{words} {write(part.mean)}, {level} CI {bracketed(part.interval, write)}, "
                f"t({part.df}) = {number(part.t)}, {p_value(p)} after Holm's correction"
            )
