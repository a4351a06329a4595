"""Describe the methods in full sentences for a paper, with references."""

from __future__ import annotations

import re
from collections.abc import Mapping

from slipscale.analysis.preprocessing import normalisation
from slipscale.analysis.tasks.difference.statistics import DIFFERENCE
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing.numbers import joined, unit_number
from slipscale.analysis.writing.references import REFERENCES, Reference
from slipscale.experiments.study.analysis_choices import Primary, ZeroRule

#: A citation in a sentence: the key of a reference, as ``[[key]]``.
CITATION = re.compile(r"\[\[([a-z0-9 ]+)\]\]")
ZEROS: dict[ZeroRule, str] = {
    "exclude": "Estimates of zero were excluded from computations on logarithms.",
    "half_minimum": "Before logarithms were taken, estimates of zero were replaced by half the "
    "smallest positive normalised estimate.",
    "refuse": "If any estimate was zero, results that require logarithms were not computed.",
}
#: Primary analysis -> the tests that belong to it.
PRIMARY: dict[Primary, str] = {
    "ranks": "tests on ranks (Friedman's and Wilcoxon's)",
    "logarithms": "tests on logarithms (analysis of variance and paired t tests)",
}


def sentences(analysis: Analysis, software: Mapping[str, str]) -> list[str]:
    """Return the paragraphs of a methods section, with references as ``[[key]]``.

    Parameters
    ----------
    software : Mapping
        Versions of the software used, keyed by name.
    """
    choices, quantity = analysis.dataset.choices, analysis.dataset.quantity
    texts = []
    if analysis.prepared is not None:
        rule = normalisation.RULES[analysis.rule]
        texts.append(
            f"Estimates were normalised ({analysis.rule}: {rule.formula.format(q=quantity)}) and "
            f"averaged for each participant and {quantity.level}. {ZEROS[choices.zero_rule]} The "
            f"primary analysis consists of the {PRIMARY[choices.primary]}. All other tests are "
            "secondary, and no correction was applied across them."
        )
    bound = choices.equivalence_ratio
    bounds = f"{1 / bound:.3g} and {bound:.3g}"
    difference = analysis.inference.found(DIFFERENCE)
    done = [
        each.methods.format(bounds=bounds, q=quantity)
        for each in analysis.inference.declared
        if each.methods
        and analysis.inference.found(each) is not None
        and not (each is DIFFERENCE and not (difference and difference.steps))
    ]
    texts.append(" ".join(done))
    level = unit_number(1 - choices.confidence, 3).rstrip("0")
    versions = {name: version for name, version in software.items() if name in CITED}
    used = joined([CITED[name].format(version) for name, version in versions.items()])
    texts.append(
        f"Tests were two-sided unless stated otherwise, with a significance level of {level}; "
        f"intervals have a confidence level of {100 * choices.confidence:g} %. Data were analysed "
        f"with Slipscale {software.get('slipscale', '')}".rstrip()
        + (f", using {used}." if used else ".")
    )
    return [text for text in texts if text]


#: Citations of software in the methods section, keyed by package; {} is replaced by the version.
CITED = {
    "scipy": "SciPy {} [[scipy2020]]",
    "pingouin": "pingouin {} [[pingouin2018]]",
    "statsmodels": "statsmodels {} [[statsmodels2010]]",
}


def cited(text: str) -> str:
    """Return a sentence with formatted citations, such as "(Holm, 1979)"."""
    return CITATION.sub(lambda found: f"({REFERENCES[found[1]].cited})", text)


def references(texts: list[str]) -> dict[str, Reference]:
    """Return the references cited in sentences, keyed by citation key and sorted by author."""
    keys = {found[1] for text in texts for found in CITATION.finditer(text)}
    return {key: REFERENCES[key] for key in sorted(keys, key=lambda key: REFERENCES[key].listed)}
