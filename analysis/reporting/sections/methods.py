"""Write the sections on normalisation rules and on methods and provenance."""

from __future__ import annotations

from collections.abc import Mapping

from slipscale.analysis.reading.cells import listed
from slipscale.analysis.reporting import methods_text
from slipscale.analysis.statistics.sensitivity import RuleSummary
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import grouped
from slipscale.experiments.dataset.schema import PARTICIPANT

SEEDS_LISTED = 12
#: Sentences on where and when the settings were chosen, keyed by `Dataset.unchanged`.
FROZEN = {
    True: "Settings from the study file, fixed before data collection (the session records "
    "contain the file's SHA-256)",
    False: "Settings from code/study.toml, which differs from the study file used in the "
    "sessions, so they may have been chosen after data collection",
    None: "Settings from code/study.toml or analysis.toml; the session records do not show "
    "whether they were chosen before data collection",
}


def normalisations(analysis: Analysis) -> ReportSection:
    """Return the section with means and standard deviations under every applicable rule."""
    section = ReportSection("Other normalisations")
    if not analysis.sensitivity:
        return section
    section.gist = [_invariance(analysis)]
    amplitudes, value = list(analysis.sensitivity[0].mean), analysis.dataset.quantity.value
    # Rules with the same results share a row.
    rules: dict[tuple[str, ...], list[RuleSummary]] = {}
    for row in analysis.sensitivity:
        cells = (f"{grouped(row.mean[a], 1)} ({grouped(row.sd_sample[a], 1)})" for a in amplitudes)
        rules.setdefault(tuple(cells), []).append(row)
    section.blocks.append(
        html.table(
            html.columns("Rule", *((value(a), "mean (SD)") for a in amplitudes), left=1),
            [[", ".join(row.rule for row in same), *cells] for cells, same in rules.items()],
            "Means under every applicable normalisation rule; the rule in use is highlighted.",
            marked=next(
                (n for n, same in enumerate(rules.values()) if any(row.used for row in same)), None
            ),
        )
    )
    return section


def _invariance(analysis: Analysis) -> str:
    """Return a sentence that states which results depend on the normalisation rule."""
    scales = analysis.dataset.estimates.groupby(PARTICIPANT, observed=True)[
        ["scale_top", "modulus"]
    ]
    if scales.nunique().gt(1).any(axis=None):
        return (
            "For some participants, the top of the scale or the standard differs between trials, "
            "so the choice of rule can also affect tests and exponents."
        )
    if (
        analysis.prepared
        and analysis.prepared.zeros
        and (analysis.dataset.choices.zero_rule == "half_minimum")
    ):
        return (
            "Ranks within participants are the same under all rules. Tests on logarithms and "
            "exponents differ slightly, because zeros are replaced by half the smallest positive "
            "estimate."
        )
    return (
        "Exponents, ranks within participants and the ANOVA on logarithms are the same under every "
        "rule of normalisation."
    )


def methods(analysis: Analysis, software: Mapping[str, str]) -> ReportSection:
    """Return the section with analysis settings, software versions, random seeds and checksums."""
    section = ReportSection("Methods and provenance")
    data = analysis.dataset
    frozen = ", ".join(data.frozen)
    versions = ", ".join(f"{name} {version}" for name, version in software.items())
    texts = methods_text.sentences(analysis, software)
    section.blocks += [html.paragraph(methods_text.cited(text)) for text in texts]
    section.blocks.append(
        html.paragraph(
            f"{FROZEN[data.unchanged]}: {frozen}."
            if frozen
            else "The study file contains no analysis settings, so Slipscale's defaults were used."
        )
    )
    rows = [
        ("Software", versions),
        ("Session software", ", ".join(data.details.get("software", ("not recorded",)))),
        ("Study's hash", ", ".join(data.details.get("study_hash", ("not recorded",)))),
        ("Seeds", listed(data.details.get("seed", ("not recorded",)), SEEDS_LISTED)),
        ("Data, SHA-256", f"{data.sha256} ({len(data.sources)} files, listed in results.json)"),
    ]
    section.blocks.append(
        html.table(
            html.columns("What", "Value", left=2),
            rows,
            "Information needed to repeat the analysis.",
        )
    )
    section.blocks.append(html.heading("References"))
    section.blocks.append(
        html.bullets((each.found_at for each in methods_text.references(texts).values()), "note")
    )
    return section
