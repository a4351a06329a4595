"""Extract the plan, plate, software and progress of a run from its journal."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from slipscale import __version__
from slipscale.experiments.journal.reading import (
    Damage,
    Reading,
    damaged,
    has_begun,
    read_records,
    read_whole,
)
from slipscale.experiments.journal.record import Record
from slipscale.experiments.journal.record_shapes import checked
from slipscale.experiments.steps.questions.base import CONSENT
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError

PACKAGES = ("slipscale", "numpy", "psychopy")


def software() -> dict[str, str]:
    """Return the versions of Python and of the packages that can affect the data."""
    return {"python": platform.python_version()} | {name: _version(name) for name in PACKAGES}


@cache
def _version(package: str) -> str:
    """Return the version of an installed package (cached, because the look-up is slow)."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def plan_from(record: Record) -> RunPlan:
    """Return the plan stored in a journal's header."""
    data = {"population": "", **record.data}
    return RunPlan(**{name: data[name] for name in RunPlan.__dataclass_fields__})


def read_plan(path: Path) -> tuple[RunPlan, list[Record]]:
    """Return a journal's plan and records, or raise `UserError` if it does not describe a run."""
    records, _ = read_records(path)
    if not records and has_begun(path):
        raise UserError(
            "journal {path}: its first line is incomplete; expected a Slipscale journal. If the "
            "session stopped as it began, start the run again with slipscale run",
            path=path,
        )
    if not records:
        raise UserError(
            "journal {path} is empty; start the run again with slipscale run", path=path
        )
    _, damage = checked(records)
    theirs = records[0].data.get("software")
    if damage and isinstance(theirs, dict) and theirs.get("slipscale") != __version__:
        raise UserError(
            "journal {path}, line {line}: not a record of this version of Slipscale, {ours} "
            "({reason}); continue with version {theirs}, which began the run",
            path=path,
            line=damage[0].line,
            ours=__version__,
            reason=damage[0].reason,
            theirs=theirs.get("slipscale"),
        )
    if damage:
        raise damaged(path, damage[0])
    return plan_from(records[0]), records


def read_usable(
    path: Path, most: int | None = None, header: Mapping[str, Any] | None = None
) -> tuple[RunPlan | None, Reading]:
    """Return the plan in a journal (None if its header is damaged) and the undamaged records.

    For the parameters, see `slipscale.experiments.journal.reading.read_whole`.

    Raises
    ------
    UserError
        If the file cannot be read, or its intact header does not describe a run.
    """
    reading = read_whole(path, most, header)
    records, more = checked(reading.records)
    reading.records = records
    reading.damage = sorted([*reading.damage, *more], key=_line)
    usable = bool(records) and records[0].kind == "header"
    return plan_from(records[0]) if usable else None, reading


def holds_records(path: Path) -> bool:
    """Return whether a journal contains at least one record, intact or damaged.

    If even the first record is incomplete, the journal counts as empty, and the run can be started
    again.
    """
    return has_begun(path) and bool(read_whole(path, most=1).records)


def _line(damage: Damage) -> int:
    return damage.line


def dataset_of(path: Path, plan: RunPlan) -> Path:
    """Return the data set folder that contains a journal.

    Raises
    ------
    UserError
        If the journal's content does not match the journal's path (the file was renamed, or is
        outside a data set).
    """
    whole = path.resolve()
    expected = plan.journal_path(Path("DATASET"))
    if whole.parts[-3:] == expected.parts[-3:]:
        return whole.parent.parent.parent
    raise UserError(
        "journal {path} was written as {expected}; restore that name and folder",
        path=path,
        expected=expected,
    )


def last_markers(records: list[Record]) -> tuple[str, ...]:
    """Return the marker outputs last used by the run, as SPECs for ``--markers``."""
    outputs = [record.data["outputs"] for record in records if record.kind == "markers"]
    return tuple(outputs[-1]) if outputs else ()


def last_backup(records: list[Record]) -> Path | None:
    """Return the backup folder last used by the run."""
    folders = [str(record.data["folder"]) for record in records if record.kind == "backup"]
    return Path(folders[-1]) if folders else None


def last_plate(records: list[Record]) -> str:
    """Return the plate specification (SPEC) with which a run was started or last resumed."""
    specs = [r.data["plate_spec"] for r in records if r.kind in ("header", "resume")]
    return str(specs[-1])


def answered_by(records: list[Record]) -> str:
    """Return who answered the questions: "person", "simulated" or "scripted"."""
    return str(records[0].data["answered_by"])


def consent_was_taken_back(records: list[Record]) -> bool:
    """Return whether the participant withdrew their consent when asked a second time."""
    again = [r.data for r in records if r.kind == "answered_again"]
    given = [data["answer"]["value"] for data in again if data["what"]["name"] == CONSENT]
    return given[-1:] == ["no"]


def elapsed_s(records: list[Record]) -> float:
    """Return the session time at which the latest step began or ended."""
    return max((r.time_s for r in records if r.kind in ("header", "begin", "done")), default=0.0)


def latest_s(records: list[Record]) -> float:
    """Return the latest session time in a journal, from which a resumed run continues."""
    return max((record.time_s for record in records), default=0.0)


def is_complete(records: list[Record]) -> bool:
    """Return whether a run reached its end."""
    return any(record.kind == "end" for record in records)
