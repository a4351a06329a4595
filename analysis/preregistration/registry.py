"""Answer the questions that registries ask about a study and its analysis.

The questions are taken from the OSF and AsPredicted forms. Authors give answers that cannot be
computed as options of the command. If an option is not given, the page shows "Not stated" as the
answer.
"""

from __future__ import annotations

from slipscale.analysis.preregistration.manifest import Manifest
from slipscale.analysis.reporting.multiplicity import multiplicity
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing.factor_words import factor_level, factor_name
from slipscale.experiments.dataset.schema import filled
from slipscale.experiments.protocol_parts.registry import load_protocol
from slipscale.experiments.steps.trial import factor_level as in_key
from slipscale.experiments.study.model import Study

NOT_STATED = "Not stated; use slipscale study freeze {option} to state it."
BLINDING = (
    "The computer generates trial orders from the study's seed. The participant's and operator's "
    "screens do not show the surface unless the operator unblinds the session."
)
MISSING = (
    "Nothing is imputed. Practice trials, voided trials and trials without an answer are left out "
    "and counted. Repeated-measures tests use only participants who have a value at every level; "
    "the report gives n for each test. Rule for zeros: {rule}."
)


def answers(plan: Manifest, analysis: Analysis, study: Study) -> list[tuple[str, str]]:
    """Return the questions with their answers.

    Parameters
    ----------
    plan : Manifest
    analysis : Analysis
        Analysis of one simulated study.
    study : Study
        The study to freeze.
    """
    confirmatory, exploratory = _families(analysis)
    return [
        ("Existing data", plan.existing_data or NOT_STATED.format(option="--existing-data TEXT")),
        *design(study),
        (
            "Sample size, rationale",
            plan.sample_size or NOT_STATED.format(option="--sample-size TEXT"),
        ),
        ("Missing data", MISSING.format(rule=plan.choices.zero_rule)),
        ("Confirmatory", confirmatory),
        ("Exploratory", exploratory),
    ]


def design(study: Study) -> list[tuple[str, str]]:
    """Return the questions about the design of a study, with their answers."""
    return [
        ("Manipulated variables", _manipulated(study)),
        ("Measured variables", _measured(study)),
        ("Blinding", BLINDING),
    ]


def _manipulated(study: Study) -> str:
    q = study.quantity
    of = "stimulus" if study.vary else "plate"
    levels = ", ".join(f"{level:g}" for level in study.levels)
    found = [f"{q.in_full_title} of the {of}: {levels} {q.unit_in_full}"] if levels else []
    if study.textures:
        found.append(f"textures: {', '.join(each.label for each in study.texture_surfaces)}")
    for task, own in study.levels_of_tasks.items():
        if not set(own) <= set(study.levels):
            found.append(f"in task {task}: {min(own):g} to {max(own):g} {q.unit_in_full}")
    for factor in study.factors:
        shown = ", ".join(factor_level(factor.name, in_key(level)) for level in factor.levels)
        found.append(f"{factor_name(factor.name)}: {shown}")
    return "; ".join(found) + "."


def _measured(study: Study) -> str:
    found = []
    for options in study.tasks:
        protocol = load_protocol(options.protocol).for_task(options)
        main = filled(protocol.response[protocol.answer].description, study.quantity)
        column = study.quantity.named(protocol.answer)
        title = protocol.titled(study.quantity)
        found.append(f"{title}: {main.rstrip('.')} (task {protocol.task}, column {column})")
    return "; ".join(found) + "."


def _families(analysis: Analysis) -> tuple[str, str]:
    """Return the names of the primary test family and of all other test families."""
    choices = analysis.dataset.choices
    found = multiplicity(
        analysis.inference, choices.primary, choices.confidence, analysis.dataset.quantity
    )
    named = [
        "; ".join(family.name for family in found.families if family.primary == primary)
        for primary in (True, False)
    ]
    return (f"{named[0]}." if named[0] else "No test."), (
        f"{named[1]}; and every result without a p-value." if named[1] else "Everything else."
    )
