"""Describe the analysis plan in words.

The description comes from the analysis of one simulated study. Real data will be analysed by the
same code.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from markupsafe import Markup

from slipscale.analysis.preprocessing import normalisation
from slipscale.analysis.preprocessing.data_quality import MEANINGS
from slipscale.analysis.reporting import methods_text
from slipscale.analysis.reporting.multiplicity import multiplicity
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.estimation.primary import TITLES
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing import html
from slipscale.experiments.study.analysis_choices import (
    AnalysisChoices,
    QualityFlag,
    Thresholds,
)
from slipscale.stimuli.quantity import Quantity


def results_of(analysis: Analysis) -> dict[str, object]:
    """Return all tests' results (or `NotComputed`) as in inference.json, other packages' last."""
    found = analysis.inference
    return {each.key: found.results[each.key] for each in found.declared if each.test}


def with_results(analysis: Analysis) -> tuple[str, ...]:
    """Return the names of the tests that have a result."""
    found = results_of(analysis)
    return tuple(name for name, result in found.items() if not isinstance(result, NotComputed))


def plan_blocks(analysis: Analysis, software: Mapping[str, str]) -> list[Markup]:
    """Return the analysis plan as paragraphs and tables."""
    choices, quantity = analysis.dataset.choices, analysis.dataset.quantity
    methods = methods_text.sentences(analysis, software)
    blocks = [html.paragraph(methods_text.cited(text)) for text in methods]
    if analysis.prepared is not None:
        rule = normalisation.RULES[analysis.rule]
        blocks += [
            html.labelled("Primary analysis", f"{TITLES[choices.primary].format(q=quantity)}."),
            html.labelled("Normalisation", f"{analysis.rule}: {rule.formula.format(q=quantity)}."),
        ]
    blocks += [
        html.labelled("Exclusions", _exclusions(choices, quantity)),
        _tests(analysis),
        *_families(analysis),
        _choices(choices),
    ]
    return blocks


def _exclusions(choices: AnalysisChoices, quantity: Quantity) -> str:
    if not choices.exclusions:
        return "No rule excludes participants; data-quality flags are for information only."
    rules = "; ".join(
        f"{flag.replace('_', ' ')}: {MEANINGS[flag].format(q=quantity)}"
        f"{_limits(flag, choices.thresholds)}"
        for flag in choices.exclusions
    )
    return (
        "A participant is excluded from every analysis, before anything is described or "
        f"tested, if one of these applies: {rules}. Other flags are for information only."
    )


def _limits(flag: QualityFlag, thresholds: Thresholds) -> str:
    """Return the threshold values that apply to a quality flag."""
    own = [
        f"{name} = {getattr(thresholds, name):g}"
        for name, field in type(thresholds).model_fields.items()
        if (field.description or "").startswith(f"Flag {flag}:")
    ]
    if flag == "fast":
        own.append(f"fast_s = {thresholds.fast_s:g}")
    return f" ({', '.join(own)})" if own else ""


def _tests(analysis: Analysis) -> Markup:
    quantity = analysis.dataset.quantity
    meanings = {each.key: each.meaning.format(q=quantity) for each in analysis.inference.declared}
    rows = [(name, meanings[name]) for name in with_results(analysis)]
    columns = html.columns("Key", "What", left=2)
    return html.table(columns, rows, "Statistics to compute, in the order of inference.json.")


def _families(analysis: Analysis) -> list[Markup]:
    choices, quantity = analysis.dataset.choices, analysis.dataset.quantity
    found = multiplicity(analysis.inference, choices.primary, choices.confidence, quantity)
    if not found.families:
        return []
    rows = [
        (
            family.name,
            "primary" if family.primary else "secondary",
            str(family.tests),
            "Holm, within the family" if family.corrected else "none",
        )
        for family in found.families
    ]
    titles: Sequence[str] = ("Family", "Part of", "Tests", "Correction")
    columns = [html.TableColumn(title=title, left=title != "Tests") for title in titles]
    level = f"{found.level:g}"
    return [
        html.table(
            columns,
            rows,
            f"Tests with a p-value, each judged at a significance level of {level}.",
        )
    ]


def _choices(choices: AnalysisChoices) -> Markup:
    """Return a table of all [analysis] settings and their sources."""
    values = choices.model_dump(mode="json")
    inner = values.pop("thresholds")
    set_in_file = choices.model_fields_set
    rows = [(key, _value(value), _whose(key, set_in_file)) for key, value in values.items()]
    of_flags = choices.thresholds.model_fields_set
    rows += [
        (f"thresholds.{key}", _value(value), _whose(key, of_flags)) for key, value in inner.items()
    ]
    columns = html.columns("Choice", "Value", "Set by", left=3)
    return html.table(columns, rows, "All settings in the study's [analysis] table.")


def _whose(key: str, set_in_file: set[str]) -> str:
    return "the study file" if key in set_in_file else "default"


def _value(value: object) -> str:
    if value is None:
        return "left out"
    return (", ".join(map(str, value)) or "none") if isinstance(value, list) else str(value)
