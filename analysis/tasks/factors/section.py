"""Write the section on factors: means by condition, the analysis of variance, the changes."""

from __future__ import annotations

from math import exp
from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declared.two_way_texts import anova_table
from slipscale.analysis.tasks.factors.statistics import FACTORS
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import cell, grouped, interval, level_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from markupsafe import Markup

    from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
    from slipscale.analysis.tasks.factors.statistics import FactorEffects
    from slipscale.analysis.tasks.kind import Analysis
    from slipscale.stimuli.quantity import Quantity


def factors(analysis: Analysis, _svgs: Mapping[str, str]) -> ReportSection:
    """Return the section; empty without factors."""
    section = ReportSection("Factors")
    quantity, level = analysis.dataset.quantity, level_of(analysis.dataset.choices.confidence)
    for found in analysis.inference[FACTORS] or ():
        section.blocks += [html.heading(found.factor), _means(found, quantity)]
        if isinstance(found.anova, NotComputed):
            reason = f"Analysis of variance: {found.anova.reason}."
            section.blocks.append(html.paragraph(reason, "note"))
        else:
            anova = found.anova
            section.blocks.append(anova_table(found.factor, anova.effects, anova.n, quantity))
        section.blocks.append(_changes(found, level))
    return section


def _means(found: FactorEffects, quantity: Quantity) -> Markup:
    levels = list(found.conditions[0].geometric_means)
    return html.table(
        [
            TableColumn(title=found.factor, left=True),
            TableColumn(title="n"),
            *(TableColumn(title=quantity.value(each)) for each in levels),
        ],
        [
            [
                each.condition,
                str(each.n),
                *(grouped(each.geometric_means[level]) for level in levels),
            ]
            for each in found.conditions
        ],
        "Geometric means by condition, averaged over other factors.",
    )


def _changes(found: FactorEffects, level: str) -> Markup:
    heads = ("Ratio of geometric means", "the same, mixed model", "Exponent", "mixed model")
    return html.table(
        [
            TableColumn(title=f"Against {found.conditions[0].condition}", left=True),
            *(TableColumn(title=head, unit=f"{level} CI") for head in heads),
        ],
        [
            [
                each.condition,
                cell(each.log_ratio, lambda one: _written(one.mean, one.interval, exp)),
                cell(each.mixed_log_ratio, lambda one: _written(one.value, one.interval, exp)),
                cell(each.exponent, lambda one: _written(one.mean, one.interval, float)),
                cell(each.mixed_exponent, lambda one: _written(one.value, one.interval, float)),
            ]
            for each in found.changes
        ],
        "Participants' own changes from the first condition (t-based interval), and the mixed "
        "model of all trials, whose ratio is at the mean logarithmic level. The model assumes that "
        "exponents change equally for everybody: if they do not, its intervals are too short.",
    )


def _written(value: float, ends: ConfidenceInterval, read: Callable[[float], float]) -> str:
    return f"{grouped(read(value))} {interval(read(ends.low), read(ends.high))}"
