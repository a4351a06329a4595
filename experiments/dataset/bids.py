"""Journals to a BIDS data set: a pure function of the journals, rebuilt at will, never edited."""

from __future__ import annotations

import json
import os
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from experiments.dataset.schema import (
    COMPLETE,
    MISSING,
    MODE,
    PARTICIPANT,
    SIDECAR,
    columns,
    person_columns,
    table_stem,
)
from experiments.dataset.trials import gather
from experiments.dataset.tsv import cell, sidecar, table
from experiments.journal.journal import has_begun, read_records
from experiments.journal.run_record import is_complete, plan_from, read_plan, software
from experiments.study.file import study_hash
from faults import UserError

if TYPE_CHECKING:
    from pathlib import Path

    from experiments.dataset.trials import Gathered
    from experiments.journal.journal import Record
    from experiments.protocols.base import Protocol
    from experiments.protocols.steps import Value
    from experiments.study.run_plan import Mode, RunPlan

BIDS_VERSION = "1.10.0"


def write_file(path: Path, content: str | dict[str, Any]) -> None:
    """Write a file whole or not at all; UserError where it cannot be written."""
    text = content if isinstance(content, str) else json.dumps(content, indent=2) + "\n"
    draft = path.with_name(f".{path.name}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        draft.write_text(text, encoding="utf-8", newline="\n")
        os.replace(draft, path)  # noqa: PTH105 - Path.replace is the same call
    except OSError as error:
        with suppress(OSError):
            draft.unlink()
        raise UserError(f"{path}: cannot be written ({error.strerror})") from None


def journals(dataset: Path) -> list[Path]:
    """Return the paths of a data set's journals, sorted."""
    return sorted((dataset / "sourcedata").glob("sub-*/*_journal.jsonl"))


def mode_of(dataset: Path) -> Mode | None:
    """Return whether a data set holds pilots or participants; None while it holds neither.

    Raises
    ------
    UserError
        It holds both.
    """
    # Their first records alone: damage further on must not keep the next participant waiting.
    firsts = [read_records(path, most=1)[0] for path in journals(dataset) if has_begun(path)]
    modes = {plan_from(records[0]).mode for records in firsts if records}
    if len(modes) > 1:
        raise UserError(f"{dataset}: holds pilots and participants; they must not be mixed")
    return modes.pop() if modes else None


def build_dataset(dataset: Path) -> None:
    """Write the data set that the journals under ``sourcedata`` give.

    Parameters
    ----------
    dataset : Path
        The data set's folder; its README.md is written once and is yours afterwards.

    Raises
    ------
    UserError
        A journal cannot be read (the message names file and line).
    """
    mode_of(dataset)
    people: dict[str, dict[str, Value]] = {}
    studies: dict[str, RunPlan] = {}
    tasks: dict[str, Protocol] = {}
    for path in journals(dataset):
        if not has_begun(path):
            continue
        plan, records = read_plan(path)
        gathered = gather(records)
        studies.setdefault(study_hash(plan.study_text), plan)
        row = people.setdefault(f"sub-{plan.participant}", {})
        row.update(gathered.person)
        row[MODE] = plan.mode
        whole = is_complete(records) and row.get(COMPLETE, "yes") == "yes"
        row[COMPLETE] = "yes" if whole else "no"
        for protocol, _ in plan.tasks():
            tasks[protocol.task] = protocol
            if gathered.trials.get(protocol.task):
                _write_run(dataset, plan, protocol, records, gathered)
    if studies:
        _write_top(dataset, people, list(studies.values()), tasks)


def _write_run(
    dataset: Path,
    plan: RunPlan,
    protocol: Protocol,
    records: list[Record],
    gathered: Gathered,
) -> None:
    """Write one task's table of one run, and its sidecar."""
    described = columns(protocol)
    rows = [
        [cell(column.value(trial)) for column in described.values()]
        for trial in gathered.trials[protocol.task]
    ]
    session = [f"ses-{plan.session}"] if plan.session else []
    folder = dataset.joinpath(f"sub-{plan.participant}", *session, "beh")
    stem = table_stem(
        participant=plan.participant, session=plan.session, task=protocol.task, run=plan.run
    )
    write_file(folder / f"{stem}.tsv", table(list(described), rows))
    first = records[0].data
    notes = {
        "study": plan.study.name,
        "study_hash": first["study_hash"],
        "seed": plan.seed,
        "mode": plan.mode,
        "language": plan.language,
        "complete": is_complete(records),
        "answered_by": first["answered_by"],
        "masking_noise": first["masking_noise"],
        "plate_spec": first["plate_spec"],
        "plate": first["plate"],
        "software": first["software"],
        # A pilot's day is of no meaning, and would make equal data sets differ.
        "started_utc": first["started_utc"] if plan.mode == "participant" else MISSING,
        "voided": [
            {"trial": trial, "reason": reason}
            for task, trial, reason in gathered.voided
            if task == protocol.task
        ],
    }
    write_file(folder / f"{stem}.json", {SIDECAR: notes})


def _write_top(
    dataset: Path,
    people: dict[str, dict[str, Value]],
    plans: list[RunPlan],
    tasks: dict[str, Protocol],
) -> None:
    """Write what belongs to the whole data set."""
    first = plans[0]
    study = first.study
    pilot = first.mode == "pilot"
    asked = {name: None for row in people.values() for name in row if name not in (MODE, COMPLETE)}
    described = person_columns(tuple(asked))
    rows = [
        [label, *(cell(row.get(name)) for name in described)]
        for label, row in sorted(people.items())
    ]
    write_file(dataset / "participants.tsv", table([PARTICIPANT, *described], rows))
    write_file(dataset / "participants.json", sidecar(described))
    write_file(
        dataset / "dataset_description.json",
        {
            "Name": f"{study.title} (simulated pilot)" if pilot else study.title,
            "BIDSVersion": BIDS_VERSION,
            "DatasetType": "raw",
            "License": study.license,
            "Authors": list(study.authors) or ["not named in the study file"],
            "GeneratedBy": [{"Name": "Slipscale", "Version": software()["slipscale"]}],
        },
    )
    for task, protocol in tasks.items():
        instructions = first.texts()[protocol.instructions].strip()
        content = {
            "TaskName": task,
            "TaskDescription": protocol.description,
            "Instructions": instructions,
            **sidecar(columns(protocol)),
        }
        write_file(dataset / f"task-{task}_beh.json", content)
    for plan in plans:
        name = "study.toml" if plan is first else f"study_{study_hash(plan.study_text)[:8]}.toml"
        write_file(dataset / "code" / name, plan.study_text)
    if not (dataset / "README.md").exists():
        write_file(dataset / "README.md", _readme(first))


def _readme(plan: RunPlan) -> str:
    """Return a data set's README."""
    study = plan.study
    kind = (
        "**Simulated.** No person took part: a pilot run of the protocol."
        if plan.mode == "pilot"
        else "Recorded from participants."
    )
    amplitudes = ", ".join(f"{amplitude:g}" for amplitude in study.amplitudes_um_pp)
    names = ", ".join(texture.name for texture in study.textures)
    textures = f"; textures {names}" if names else ""
    return (
        f"# {study.title}\n\n{kind}\n\n"
        f"Study `{study.name}`, recorded with Slipscale; plate amplitudes {amplitudes} µm peak to "
        f"peak{textures}.\n\n"
        "`sourcedata/` holds the journals, from which all tables here were made and can be made "
        "again; `code/` holds the study file. The JSON file beside a table says what its columns "
        "mean. Rows flagged `voided` and rows of the phase `practice` are not to be analysed.\n"
    )
