"""Generate the content of a data set's files from its runs, without access to the data set.

`render` generates the content of all files from the journals. `slipscale.experiments.dataset.bids`
writes the files, and `slipscale.experiments.dataset.verification` compares them with the existing
ones.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import PurePosixPath
from typing import TYPE_CHECKING

from slipscale.experiments.dataset.further_tables.events import (
    HED_VERSION,
    events,
    events_of,
    events_sidecar,
)
from slipscale.experiments.dataset.further_tables.headphones import headphone_result
from slipscale.experiments.dataset.further_tables.person_columns import (
    person_columns,
    session_columns,
)
from slipscale.experiments.dataset.further_tables.phenotype import phenotype
from slipscale.experiments.dataset.further_tables.time_series import series_of
from slipscale.experiments.dataset.journals import Problem, Run
from slipscale.experiments.dataset.schema import (
    COMPLETE,
    MISSING,
    MODE,
    PARTICIPANT,
    SESSION,
    SIDECAR,
    columns,
    filled,
    table_stem,
)
from slipscale.experiments.dataset.tsv import cell, sidecar, table
from slipscale.experiments.journal.plan_and_progress import software
from slipscale.experiments.journal.serialisation import in_file
from slipscale.experiments.steps.questions.base import CONSENT
from slipscale.experiments.study.file import study_hash
from slipscale.faults.message import Message

if TYPE_CHECKING:
    from slipscale.experiments.dataset.files import Content
    from slipscale.experiments.protocol_parts.base import Protocol
    from slipscale.experiments.steps.columns import Column
    from slipscale.experiments.steps.trial import Value
    from slipscale.experiments.study.model import Study
    from slipscale.experiments.study.run_plan import RunPlan

BIDS_VERSION = "1.10.0"
README, GIT_ATTRIBUTES = PurePosixPath("README.md"), PurePosixPath(".gitattributes")
# Endings of files in which git must not convert line ends.
KEPT_BY_GIT = ("jsonl", "tsv", "json")


def render(runs: Sequence[Run]) -> tuple[dict[PurePosixPath, Content], list[Problem]]:
    """Return the content of all files, keyed by path in the data set, and the problems found.

    If a run's records are intact but do not match the protocol's table, the run is reported as a
    problem and no files are generated for it.
    """
    files: dict[PurePosixPath, Content] = {}
    problems: list[Problem] = []
    people: dict[str, dict[str, Value]] = {}
    studies: dict[str, RunPlan] = {}
    tasks: dict[str, Protocol] = {}
    measured: dict[str, set[str]] = {}
    sessions: dict[str, dict[str, list[Run]]] = {}
    fit: list[Run] = []
    for run in runs:
        plan = run.plan
        protocols = {protocol.task: protocol for protocol, _ in plan.tasks()}
        labelled = {p.task: options.protocol for p, options in plan.tasks() if options.label}
        try:
            own = [
                file
                for protocol in protocols.values()
                if run.gathered.trials.get(protocol.task)
                for file in _run_files(run, protocol, labelled.get(protocol.task, ""))
            ]
        except (LookupError, TypeError, ValueError, AttributeError) as error:
            name = "/".join(run.path.parts[-3:])
            problems.append(
                Problem(
                    file=name,
                    what=Message(
                        "the run's records do not match its tables ({error})", error=repr(error)
                    ),
                )
            )
            continue
        files.update(own)
        fit.append(run)
        if plan.session:
            sessions.setdefault(plan.participant, {}).setdefault(plan.session, []).append(run)
        studies.setdefault(study_hash(plan.study_text), plan)
        row = people.setdefault(f"sub-{plan.participant}", {})
        row.update(run.gathered.person)
        row[MODE] = plan.mode
        row[COMPLETE] = "yes" if run.complete and row.get(COMPLETE, "yes") == "yes" else "no"
        tasks.update(protocols)
        for task in protocols:
            measured.setdefault(task, set()).update(run.gathered.measured(task))
    for participant, theirs in sessions.items():
        files.update(_sessions(participant, theirs))
    files.update(phenotype(fit))
    if studies:
        simulated = {run.records[0].data["answered_by"] for run in runs} == {"simulated"}
        files.update(_top(people, list(studies.values()), tasks, measured, simulated=simulated))
    return files, problems


def _sessions(
    participant: str, sessions: dict[str, list[Run]]
) -> Iterator[tuple[PurePosixPath, Content]]:
    """Yield the table of a participant's sessions, and its sidecar."""
    described = session_columns()
    path = PurePosixPath(f"sub-{participant}", f"sub-{participant}_sessions.tsv")
    rows = [
        [f"ses-{session}", *(cell(value) for value in _session_row(runs))]
        for session, runs in sorted(sessions.items())
    ]
    yield path, table([SESSION, *described], rows)
    yield path.with_suffix(".json"), sidecar(described)


def _session_row(runs: list[Run]) -> tuple[Value, ...]:
    """Return when a session started and whether all of its runs are complete."""
    # A pilot's date is omitted, so that a pilot repeated with the same seed gives the same data.
    person = runs[0].plan.mode == "participant"
    began = min(str(run.records[0].data["started_utc"]) for run in runs)
    complete = all(run.complete for run in runs)
    return (began.replace("+00:00", "Z") if person else None, "yes" if complete else "no")


def stem_of(run: Run, task: str) -> PurePosixPath:
    """Return the common path of the table and the sidecar for a task in a run, without a suffix."""
    plan = run.plan
    session = [f"ses-{plan.session}"] if plan.session else []
    stem = table_stem(participant=plan.participant, session=plan.session, task=task, run=plan.run)
    return PurePosixPath(f"sub-{plan.participant}", *session, "beh", stem)


def _columns(protocol: Protocol, measured: Iterable[str], study: Study) -> dict[str, Column]:
    second = study.second_plate
    made = second.quantity.quantity if second else None
    return columns(protocol, measured, study.quantity, study.plate_quantity, made)


def _run_files(
    run: Run, protocol: Protocol, labelled: str
) -> Iterator[tuple[PurePosixPath, Content]]:
    """Yield the table for one task in a run, and its sidecar."""
    plan, records, gathered = run.plan, run.records, run.gathered
    described = _columns(protocol, gathered.measured(protocol.task), plan.study)
    rows = [
        [cell(column.value(trial), column.units) for column in described.values()]
        for trial in gathered.trials[protocol.task]
    ]
    path = stem_of(run, protocol.task)
    yield path.with_suffix(".tsv"), table(list(described), rows)
    yield events_of(path), events(described, gathered.trials[protocol.task])
    first = records[0].data
    person = plan.mode == "participant"
    notes = {
        "study": plan.study.name,
        **({"protocol": labelled} if labelled else {}),
        "study_hash": first["study_hash"],
        "seed": plan.seed,
        "mode": plan.mode,
        "language": plan.language,
        "texts_hash": first["texts_hash"],
        "complete": run.complete,
        "answered_by": first["answered_by"],
        "masking_noise": first["masking_noise"],
        **(
            {"headphone_test": headphone_result(records, plan.study.headphone_test)}
            if plan.study.headphone_test
            else {}
        ),
        **plan.study.quantity_notes(),
        "plate_spec": first["plate_spec"],
        "plate": first["plate"],
        "contact": first.get("contact", MISSING),
        "software": first["software"],
        # A pilot's date, number of interruptions and journal hash (which depends on both) are
        # omitted, so that a pilot repeated with the same seed gives the same sidecar.
        "started_utc": first["started_utc"] if person else MISSING,
        "resumes": _resumes(run) if person else MISSING,
        "voided": [
            {"trial": trial, "reason": reason}
            for task, trial, reason in gathered.voided
            if task == protocol.task
        ],
        "damaged": [str(damage) for damage in run.damage],
        "journal": {"records": len(records), "hash": records[-1].hash or MISSING}
        if person
        else MISSING,
    }
    remarks = [
        {"time_s": record.time_s, "text": record.data["text"]}
        for record in records
        if record.kind == "note"
    ]
    yield (
        path.with_suffix(".json"),
        {SIDECAR: in_file(first)(notes) | ({"notes": remarks} if remarks else {})},
    )
    for kind, content, told in series_of(records, protocol.task):
        name = f"{path.name.removesuffix('_beh')}_recording-{kind}_physio"
        yield path.with_name(f"{name}.tsv.gz"), content
        yield path.with_name(f"{name}.json"), dict(told)


def _resumes(run: Run) -> list[dict[str, object]]:
    """Return the equipment and software in use each time the run was resumed."""
    return [
        {
            "time_s": record.time_s,
            "resumed_utc": record.data.get("resumed_utc", MISSING),
            **{
                name: record.data[name]
                for name in ("plate_spec", "plate", "masking_noise", "software")
            },
            "texts_hash": record.data["texts_hash"],
            "contact": record.data.get("contact", MISSING),
        }
        for record in run.records
        if record.kind == "resume"
    ]


def _top(
    people: dict[str, dict[str, Value]],
    plans: list[RunPlan],
    tasks: dict[str, Protocol],
    measured: Mapping[str, Collection[str]],
    *,
    simulated: bool,
) -> Iterator[tuple[PurePosixPath, Content]]:
    """Yield the files that belong to the data set as a whole."""
    first = plans[0]
    study = first.study
    pilot = " (simulated pilot)" if simulated else " (pilot)"
    described = person_columns(_questions(people, plans))
    if CONSENT in described:
        described[CONSENT] = _consent(described[CONSENT], first)
    rows = [
        [label, *(cell(row.get(name)) for name in described)]
        for label, row in sorted(people.items())
    ]
    yield PurePosixPath("participants.tsv"), table([PARTICIPANT, *described], rows)
    yield PurePosixPath("participants.json"), sidecar(described)
    description = {
        "Name": study.title + (pilot if first.mode == "pilot" else ""),
        "BIDSVersion": BIDS_VERSION,
        "HEDVersion": HED_VERSION,
        "DatasetType": "raw",
        "License": study.license,
        "Authors": _authors(study, simulated=simulated),
        "GeneratedBy": [{"Name": "Slipscale", "Version": software()["slipscale"]}],
    }
    yield PurePosixPath("dataset_description.json"), description
    for task, protocol in tasks.items():
        instructions = first.texts()[protocol.instructions].strip()
        described = _columns(protocol, measured[task], first.study)
        content = {
            "TaskName": task,
            "TaskDescription": filled(protocol.description, first.study.quantity),
            "Instructions": instructions,
        }
        yield PurePosixPath(f"task-{task}_beh.json"), content | sidecar(described)
        yield PurePosixPath(f"task-{task}_events.json"), content | events_sidecar(described)
    for plan in plans:
        name = "study.toml" if plan is first else f"study_{study_hash(plan.study_text)[:8]}.toml"
        yield PurePosixPath("code", name), plan.study_text
    yield README, _readme(first, simulated=simulated)
    # Checksums cover the bytes, so git must not convert line ends.
    yield GIT_ATTRIBUTES, "".join(f"*.{end} -text\n" for end in KEPT_BY_GIT)


def _authors(study: Study, *, simulated: bool) -> list[str]:
    """Return the authors of the data; nobody collected simulated data."""
    if simulated:
        return ["simulated by Slipscale"]
    return list(study.authors) or ["not named in the study file"]


def _consent(column: Column, plan: RunPlan) -> Column:
    """Add the text that participants read to the description of the consent column."""
    texts = plan.texts()
    asked, read = texts["session.consent_question"], texts["session.consent"].strip()
    return replace(
        column,
        description=f"Answer to the question '{asked}', which followed this text: {read}",
    )


def _questions(
    people: dict[str, dict[str, Value]], plans: list[RunPlan]
) -> dict[str, dict[str, str]]:
    """Return the labels of the answer codes for each question about the participants."""
    asked: dict[str, dict[str, str]] = {
        name: {} for row in people.values() for name in row if name not in (MODE, COMPLETE)
    }
    if CONSENT in asked:
        asked[CONSENT] = {"yes": "agreed to take part", "no": "did not agree"}
    # Reversed, so that the first study's wording is used if two studies use the same answer code.
    for plan in reversed(plans):
        for question in plan.study.about_you:
            if question.name in asked:
                asked[question.name].update(question.levels(plan.study.language))
    return asked


def _readme(plan: RunPlan, *, simulated: bool) -> str:
    """Return the text of README.md, which states whether the data come from pilots."""
    study = plan.study
    kinds = {
        "pilot": "**Pilot.** These answers come from people who tried out the study; they are not "
        "data. The JSON file next to each table states who answered (`answered_by`) and on which "
        "plate (`plate`).",
        "participant": "Recorded from participants.",
    }
    kind = (
        "**Simulated.** No person took part: this is a pilot run of the protocol."
        if simulated
        else kinds[plan.mode]
    )
    q = study.quantity
    amplitudes = ", ".join(f"{level:g}" for level in study.levels)
    what = q.levels if study.vary else Message("plate {levels}", levels=q.levels)
    names = ", ".join(texture.name for texture in study.textures)
    textures = f"; textures {names}" if names else ""
    return (
        f"# {study.title}\n\n{kind}\n\nStudy `{study.name}`, recorded with Slipscale; {what} "
        f"{amplitudes} {q.unit_in_full}{textures}.\n\n`sourcedata/` contains the journals, from "
        "which all tables were generated and can be rebuilt; `code/` contains the study file. The "
        "JSON file next to each table describes its columns. Do not analyse rows with the flag "
        "`voided` or the phase `practice`.\n"
    )
