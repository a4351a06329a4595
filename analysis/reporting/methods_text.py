"""What was done, in full sentences for a paper's methods section, with its references."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from slipscale.analysis.preprocessing import normalisation
from slipscale.analysis.reporting.numbers import unit_number
from slipscale.analysis.reporting.references import REFERENCES
from slipscale.analysis.statistics.not_computed import NotComputed

if TYPE_CHECKING:
    from collections.abc import Mapping

    from slipscale.analysis.reporting.references import Reference
    from slipscale.analysis.result import Analysis
    from slipscale.experiments.study.analysis_choices import Primary, ZeroRule

#: [[key]] in a sentence cites a reference.
CITATION = re.compile(r"\[\[([a-z0-9 ]+)\]\]")
ZEROS: dict[ZeroRule, str] = {
    "exclude": "Estimates of zero were left out of what was computed on logarithms.",
    "half_minimum": "For logarithms, estimates of zero were replaced by half the smallest positive "
    "normalised estimate.",
    "refuse": "Nothing was to be computed on logarithms if an estimate was zero.",
}
PRIMARY: dict[Primary, str] = {
    "ranks": "The primary analysis was Friedman's test of ranks [[friedman1937]], followed by "
    "Wilcoxon's signed-rank test of each pair of amplitudes [[wilcoxon1945]], with Holm's "
    "correction [[holm1979]].",
    "logarithms": "The primary analysis was a repeated-measures analysis of variance of mean "
    "logarithms with Greenhouse and Geisser's correction [[greenhouse1959]], followed by paired t "
    "tests of each pair of amplitudes, with Holm's correction [[holm1979]].",
}
#: A test's field of `Inference` -> its sentence.
TESTS = {
    "rm_anova": "Log estimates were compared between amplitudes by a repeated-measures analysis "
    "of variance with Greenhouse and Geisser's correction [[greenhouse1959]]; its effect size is "
    "generalised eta squared [[olejnik2003]].",
    "page_trend": "An ordered trend was tested by Page's test [[page1963]].",
    "pairwise": "Whether two amplitudes were equal was tested by two one-sided tests of the ratio "
    "of geometric means [[schuirmann1987]], with bounds of {bounds}, and by a Bayes factor with a "
    "Cauchy prior of scale 0.707 [[rouder2009]].",
    "sessions": "Sessions were compared by an analysis of variance of mean log estimates with "
    "session and amplitude within participants, Greenhouse and Geisser's correction "
    "[[greenhouse1959]], and by each participant's change from the first session, with Holm's "
    "correction over all changes [[holm1979]]; agreement between sessions is the intraclass "
    "correlation ICC(A,1) [[mcgraw1996]].",
    "power_law": "Exponents are the means of participants' slopes of log estimates on log "
    "amplitude [[stevens1957]], with Student's intervals over participants.",
}
DIFFERENCE = (
    "Shares of “yes” have Clopper and Pearson's intervals, of as many answers as there would be "
    "independent ones [[korn1998]]. “Yes” was related to the size of the step by a logistic "
    "curve, fitted by generalised estimating equations with exchangeable answers of a participant "
    "[[liang1986]] and errors for few participants [[mancl2001]]. Sensitivity, d′, comes from a "
    "probit model with participants, with intervals of its profile likelihood; a participant's "
    "own d′ and c have the log-linear correction [[hautus1995]]."
)


def sentences(analysis: Analysis, software: Mapping[str, str]) -> list[str]:
    """Return the paragraphs of a methods section, references as ``[[key]]``.

    Parameters
    ----------
    software : Mapping
        Name -> version of what took part.
    """
    choices = analysis.dataset.choices
    texts = []
    if analysis.prepared is not None:
        bound = choices.equivalence_ratio
        bounds = f"{1 / bound:.3g} and {bound:.3g}"
        done = [
            text.format(bounds=bounds)
            for name, text in TESTS.items()
            if not isinstance(getattr(analysis.inference, name), NotComputed)
            and not (name == "rm_anova" and choices.primary == "logarithms")
        ]
        rule = normalisation.RULES[analysis.rule]
        texts += [
            (
                f"Estimates were normalised ({analysis.rule}: {rule.formula}) and averaged for "
                f"each participant and amplitude. {ZEROS[choices.zero_rule]} "
                f"{PRIMARY[choices.primary]} Every other test is secondary, and not corrected for "
                "the others."
            ),
            " ".join(done),
        ]
    difference = analysis.inference.difference
    if not isinstance(difference, NotComputed) and difference.steps:
        texts.append(DIFFERENCE)
    level = unit_number(1 - choices.confidence, 3).rstrip("0")
    versions = {name: version for name, version in software.items() if name in CITED}
    used = ", ".join(f"{CITED[name]} {version}" for name, version in versions.items())
    texts.append(
        f"Tests were two-sided unless named otherwise and judged at {level}; intervals are of "
        f"{100 * choices.confidence:g} %. The analysis was done with Slipscale "
        f"{software.get('slipscale', '')}".rstrip()
        + (f", using {used}." if used else ".")
    )
    return [text for text in texts if text]


#: Software that a methods section cites: a name of the versions -> how.
CITED = {
    "scipy": "SciPy [[scipy2020]]",
    "pingouin": "pingouin [[pingouin2018]]",
    "statsmodels": "statsmodels [[statsmodels2010]]",
}


def cited(text: str) -> str:
    """Return a sentence as it is printed: "(Holm, 1979)"."""
    return CITATION.sub(lambda found: f"({REFERENCES[found[1]].cited})", text)


def references(texts: list[str]) -> dict[str, Reference]:
    """Return the references that sentences cite, by key, in alphabetical order of authors."""
    keys = {found[1] for text in texts for found in CITATION.finditer(text)}
    return {key: REFERENCES[key] for key in sorted(keys, key=lambda key: REFERENCES[key].listed)}
