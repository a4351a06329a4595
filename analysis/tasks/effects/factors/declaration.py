"""Define how factors crossed with the levels are analysed and reported."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import exp
from typing import TYPE_CHECKING

from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants
from slipscale.analysis.statistics.mixed_model import BOUND_SENTENCE
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declared.two_way_texts import anova_sentence, anova_table
from slipscale.analysis.tasks.effects.factors.statistics import (
    FACTORS,
    ConditionChange,
    ConditionMeans,
    FactorEffects,
)
from slipscale.analysis.tasks.kind import Analysis, TaskAnalysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.factor_words import factor_level, factor_name
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import (
    bracketed,
    cell,
    grouped,
    interval,
    level_of,
    number,
    p_value,
)
from slipscale.analysis.writing.verdicts import DIFFERED, verdict
from slipscale.stimuli.quantity import capitalised

if TYPE_CHECKING:
    from markupsafe import Markup

    from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
    from slipscale.stimuli.quantity import Quantity

    Change = MeanOverParticipants | NotComputed


def sentences(analysis: Analysis) -> list[str]:
    """Return the sentences on all factors, in APA style (7th edition)."""
    confidence, quantity = analysis.dataset.choices.confidence, analysis.dataset.quantity
    texts = []
    for each in analysis.inference[FACTORS] or ():
        anova, name = each.anova, factor_name(each.factor)
        if isinstance(anova, NotComputed):
            texts.append(f"The analysis of variance with {name} was not computed: {anova.reason}.")
        else:
            names = (name, f"{name} conditions")
            texts.append(anova_sentence(names, anova.effects, anova.n, confidence, quantity))
        first = factor_level(each.factor, each.conditions[0].condition)
        for change in each.changes:
            parts = "; ".join(_parts(change, confidence))
            if parts:
                level = factor_level(each.factor, change.condition)
                texts.append(f"{capitalised(name)} {level} compared with {first}: {parts}.")
    return texts


def _parts(change: ConditionChange, confidence: float) -> Iterator[str]:
    level = level_of(confidence)

    def ratio(value: float) -> str:
        return number(exp(value))

    parts: tuple[tuple[str, str, Change, float | None, Callable[[float], str]], ...] = (
        ("geometric means", "ratio", change.log_ratio, change.log_ratio_p_holm, ratio),
        ("exponents", "difference", change.exponent, change.exponent_p_holm, number),
    )
    for what, by, part, p, write in parts:
        if isinstance(part, MeanOverParticipants) and p is not None:
            yield (
                f"{what} {verdict(DIFFERED, p, confidence, part.df)} ({by} {write(part.mean)}, "
                f"{level} CI {bracketed(part.interval, write)}, t({part.df}) = {number(part.t)}, "
                f"{p_value(p)} after Holm's correction)"
            )


def _means(found: FactorEffects, quantity: Quantity) -> Markup:
    levels = list(found.conditions[0].geometric_means)
    return html.table(
        html.columns(
            capitalised(factor_name(found.factor)), "n", *map(quantity.value, levels), left=1
        ),
        [
            [
                factor_level(found.factor, each.condition),
                str(each.n),
                *(_mean(each, level) for level in levels),
            ]
            for each in found.conditions
        ],
        "Geometric means by condition, averaged over other factors. A mean of fewer participants "
        "than the condition has states its own n.",
    )


def _mean(found: ConditionMeans, level: float) -> str:
    own = found.ns[level]
    return grouped(found.geometric_means[level]) + (f" (n = {own})" if own != found.n else "")


def _changes(found: FactorEffects, level: str) -> Markup:
    singular = found.mixed and found.mixed.at_bound
    bound = f" In the mixed model, {BOUND_SENTENCE}." if singular else ""
    heads = ("Ratio of geometric means", "Ratio, mixed model", "Exponent", "Exponent, mixed model")
    return html.table(
        html.columns(
            f"Compared with {factor_level(found.factor, found.conditions[0].condition)}",
            *((head, f"{level} CI") for head in heads),
            left=1,
        ),
        [
            [
                factor_level(found.factor, each.condition),
                cell(each.log_ratio, lambda one: _written(one.mean, one.interval, exp)),
                cell(each.mixed_log_ratio, lambda one: _written(one.value, one.interval, exp)),
                cell(each.exponent, lambda one: _written(one.mean, one.interval, float)),
                cell(each.mixed_exponent, lambda one: _written(one.value, one.interval, float)),
            ]
            for each in found.changes
        ],
        "Mean changes from the first condition across participants, with t-based "
        "intervals, and estimates from a mixed model of all trials. The model's ratio is "
        "the ratio at the mean logarithmic level. The model assumes that exponents change equally "
        f"for all participants; otherwise, the model's intervals are too narrow.{bound}",
    )


def _written(value: float, ends: ConfidenceInterval, read: Callable[[float], float]) -> str:
    return f"{grouped(read(value))} {interval(read(ends.low), read(ends.high))}"


class _Factors(TaskAnalysis):
    name = "factors"
    statistics = (FACTORS,)

    def answers(self, analysis: Analysis) -> list[str]:
        return sentences(analysis)

    def sentences(self, analysis: Analysis) -> Mapping[str, list[str]]:
        return {"Factors": sentences(analysis)}

    def sections(self, analysis: Analysis, _svgs: Mapping[str, str]) -> list[ReportSection]:
        """Return the section on factors, which is empty if the study has no factors."""
        section = ReportSection("Factors")
        quantity, level = analysis.dataset.quantity, level_of(analysis.dataset.choices.confidence)
        for found in analysis.inference[FACTORS] or ():
            name = factor_name(found.factor)
            section.blocks += [html.heading(capitalised(name)), _means(found, quantity)]
            if isinstance(found.anova, NotComputed):
                reason = f"The analysis of variance was not computed: {found.anova.reason}."
                section.blocks.append(html.paragraph(reason, "note"))
            else:
                anova = found.anova
                section.blocks.append(anova_table(name, anova.effects, anova.n, quantity))
            section.blocks.append(_changes(found, level))
        return [section]


ANALYSIS = _Factors()
