"""Determine the state of a run, and explain how to continue if its journal already exists."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from slipscale.experiments.dataset.journals import journals, mode_of
from slipscale.experiments.dataset.withdrawn import replacement, withdrawn
from slipscale.experiments.journal.locks import is_being_written
from slipscale.experiments.journal.plan_and_progress import is_complete, read_usable
from slipscale.experiments.journal.reading import has_begun
from slipscale.experiments.journal.record import Record
from slipscale.experiments.study.run_plan import JOURNAL_NAME, Mode
from slipscale.faults import UserError
from slipscale.faults.folders import visible
from slipscale.faults.message import Message

if TYPE_CHECKING:
    from slipscale.experiments.journal.journal import Journal

RunState = Literal["free", "running now", "interrupted", "complete", "damaged"]


def run_state(path: Path) -> RunState:
    """Return the state of the run in a journal; "free" if the run has not begun."""
    if is_being_written(path):
        return "running now"
    if not has_begun(path):
        return "free"
    _, reading = read_usable(path)
    if not reading.records:
        return "free"  # empty: the machine stopped while writing the first record
    if reading.damage:
        return "damaged"
    return "complete" if is_complete(reading.records) else "interrupted"


def participants(dataset: Path) -> list[str]:
    """Return the sorted labels of a data set's participants, including those who withdrew."""
    folders = visible(dataset / "sourcedata", "sub-*")
    present = {folder.name.removeprefix("sub-") for folder in folders}
    return sorted(present.union(withdrawn(dataset)))


def check_alike(dataset: Path, participant: str, *, session: str = "", run: str = "01") -> None:
    """Raise `UserError` if a label of a new run exists in an equivalent form, such as 1 for 01.

    Participants or runs with equivalent labels would be analysed as different ones. Upper and lower
    case are not distinguished, because some file systems treat A and a as equal.
    """
    for label in withdrawn(dataset):
        if _plain(label) == _plain(participant):
            raise UserError(
                "--participant {participant}: this participant withdrew from {dataset}, and the "
                "label is not used again; the replacement is participant {replacement}",
                participant=participant,
                dataset=dataset,
                replacement=replacement(label),
            )
    for label in participants(dataset):
        if label != participant and _plain(label) == _plain(participant):
            raise UserError(
                "--participant {participant}: {dataset} already has a participant {label}; "
                "expected that label for the same person, or another number for another person",
                participant=participant,
                dataset=dataset,
                label=label,
            )
    for had_session, had_run in _visits(dataset, participant):
        if had_session != session and _plain(had_session) == _plain(session):
            raise UserError(
                "--session {session}: participant {participant} already has a session "
                "{had_session}; expected that label for the same session, or another one",
                session=session,
                participant=participant,
                had_session=had_session,
            )
        if (had_session, _plain(had_run)) == (session, _plain(run)) and had_run != run:
            raise UserError(
                "--run {run}: participant {participant} already has a run {had_run}; expected "
                "that label for the same run, or another number for another run",
                run=run,
                participant=participant,
                had_run=had_run,
            )


def _plain(label: str) -> str:
    return label.casefold().lstrip("0")


def _visits(dataset: Path, participant: str) -> Iterator[tuple[str, str]]:
    """Yield the session and run labels of a participant's journals."""
    for path in journals(dataset):
        found = JOURNAL_NAME.fullmatch(path.name)
        if found and found["participant"] == participant:
            yield found["session"] or "", found["run"]


# Default folder for each mode; pilots and participants must not share a folder.
FOLDERS: dict[Mode, str] = {"participant": "data", "pilot": "pilots/rehearsals"}


def check_mode(dataset: Path, mode: Mode) -> None:
    """Raise `UserError` if a data set was recorded in another mode."""
    held = mode_of(dataset)
    if held and held != mode:
        raise UserError(
            "--out {dataset}: contains {held} data, which must not be mixed with {mode} data. "
            "Name another folder (--out {folder}), or, if this is to be a {held} run, {remedy}",
            dataset=dataset,
            held=held,
            mode=mode,
            folder=FOLDERS[mode],
            remedy="add --pilot" if held == "pilot" else "name the real plate and omit --pilot",
        )


def studies(dataset: Path) -> list[str]:
    """Return the names of a data set's studies, in the order of their first runs."""
    found: dict[str, None] = {}
    for path in journals(dataset):
        with suppress(UserError):
            plan, _ = read_usable(path, most=1)
            if plan:
                found[plan.study.name] = None
    return list(found)


def check_same_study(dataset: Path, study: str) -> None:
    """Raise `UserError` if a data set contains runs of other studies only."""
    held = studies(dataset)
    if held and study not in held:
        raise UserError(
            "--out {dataset}: contains the study {held}, but this is '{study}'; name another "
            "folder with --out, or add --add-study to keep both there",
            dataset=dataset,
            held=", ".join(held),
            study=study,
        )


def remedy(path: Path, state: RunState) -> str:
    """Return advice on what to do if a run has already begun."""
    another = "name another participant, or a new --session or --run"
    remedies: dict[RunState, str] = {
        "running now": Message("end it there, or {another}", another=another),
        "interrupted": how_to_resume(path),
        "complete": another,
        "damaged": (
            Message(
                "the undamaged records are used (for details: slipscale data verify); {another}",
                another=another,
            )
        ),
    }
    return remedies[state]


def check_unfinished(journal: Path, records: list[Record]) -> None:
    """Raise `UserError` if a run is complete and cannot be resumed."""
    if is_complete(records):
        dataset = shlex.quote(str(journal.resolve().parents[2]))
        raise UserError(
            "journal {journal}: this run is complete and all its answers are saved; there is "
            "nothing to resume. If its tables are missing: slipscale data build {dataset}",
            journal=journal,
            dataset=dataset,
        )


def how_to_resume(journal: Path) -> str:
    """Return a sentence that explains how to resume a run."""
    return Message("To continue: slipscale resume {journal}", journal=shlex.quote(str(journal)))


def not_built(fault: UserError, dataset: Path, journal: Journal) -> str:
    """Return sentences on why a run's tables were not written, and on the state of the run."""
    build = f"slipscale data build {shlex.quote(str(dataset))}"
    if is_complete(journal.records):
        return Message(
            "{fault}. The run is complete and all answers are saved in {journal_path}. "
            "Correct the error, then write the tables: {build}",
            fault=fault,
            journal_path=journal.path,
            build=build,
        )
    return Message(
        "{fault}. The run was stopped and all answers so far are saved in {journal_path}. "
        "Correct the error, then write the tables: {build}. {how_to_resume}",
        fault=fault,
        journal_path=journal.path,
        build=build,
        how_to_resume=how_to_resume(journal.path),
    )
