"""Generate the tables for questionnaires, which are stored in the BIDS folder ``phenotype``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import PurePosixPath
from typing import TYPE_CHECKING

from slipscale.experiments.dataset.further_tables.person_columns import questionnaire_columns
from slipscale.experiments.dataset.schema import PARTICIPANT, RUN, SESSION
from slipscale.experiments.dataset.tsv import cell, sidecar, table

if TYPE_CHECKING:
    from slipscale.experiments.dataset.journals import Run

FOLDER = PurePosixPath("phenotype")


def phenotype(runs: Sequence[Run]) -> Iterator[tuple[PurePosixPath, str | dict[str, object]]]:
    """Yield a table (one row per administration) and a sidecar for each questionnaire."""
    answers: dict[str, list[Run]] = {}
    for run in runs:
        for questionnaire in run.plan.study.questionnaires:
            if run.gathered.run_answers.get(questionnaire.name):
                answers.setdefault(questionnaire.name, []).append(run)
    for name, answered in answers.items():
        yield from _of_one(name, answered)


def _of_one(name: str, runs: list[Run]) -> Iterator[tuple[PurePosixPath, str | dict[str, object]]]:
    items: dict[str, tuple[str, dict[str, str]]] = {}
    description = ""
    for run in reversed(runs):  # if two studies share an item, the first study's words are used
        study = run.plan.study
        questionnaire = next(each for each in study.questionnaires if each.name == name)
        items = {**items, **questionnaire.levels(study.language)}
        description = questionnaire.description
    plans = [run.plan for run in runs]
    once = {(plan.participant, plan.session) for plan in plans}
    visits = [
        *([SESSION] if any(plan.session for plan in plans) else []),
        *([RUN] if len(once) < len(plans) else []),
    ]
    described = questionnaire_columns(items, visits)
    rows = []
    for run in sorted(runs, key=lambda run: (run.plan.participant, run.plan.session, run.plan.run)):
        plan, given = run.plan, run.gathered.run_answers[name]
        which = {SESSION: f"ses-{plan.session}" if plan.session else None, RUN: plan.run}
        values = {**given, **{column: which[column] for column in visits}}
        rows.append([f"sub-{plan.participant}", *(cell(values.get(key)) for key in described)])
    path = FOLDER / f"{name}.tsv"
    yield path, table([PARTICIPANT, *described], rows)
    about = {"MeasurementToolMetadata": {"Description": description}}
    yield path.with_suffix(".json"), {**about, **sidecar(described)}
