"""What a run's journal says of the run itself: its plan, plate, software and how far it came."""

from __future__ import annotations

import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.experiments.journal.reading import damaged, has_begun, read_records, read_whole
from slipscale.experiments.journal.record_shapes import checked
from slipscale.experiments.protocols.steps import CONSENT
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.experiments.journal.reading import Damage, Reading
    from slipscale.experiments.journal.record import Record

PACKAGES = ("slipscale", "numpy", "psychopy")


def software() -> dict[str, str]:
    """Return the versions of what a run's data can depend on, without importing it."""
    return {"python": platform.python_version()} | {name: _version(name) for name in PACKAGES}


@cache
def _version(package: str) -> str:
    """Return an installed package's version: a look-up of milliseconds, and none changes."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def plan_from(record: Record) -> RunPlan:
    """Return the plan that a journal's header holds."""
    data = {"population": "", **record.data}
    return RunPlan(**{name: data[name] for name in RunPlan.__dataclass_fields__})


def read_plan(path: Path) -> tuple[RunPlan, list[Record]]:
    """Return a journal's plan and records; UserError unless it is a run's."""
    records, _ = read_records(path)
    if not records:
        raise UserError(f"journal {path}: holds nothing; begin the run anew with slipscale run")
    _, damage = checked(records)
    if damage:
        raise damaged(path, damage[0])
    return plan_from(records[0]), records


def read_usable(path: Path, most: int | None = None) -> tuple[RunPlan | None, Reading]:
    """Return what is whole of a run's journal, and its plan; None where the header is not whole.

    With ``most``, no line further on is looked at.

    Raises
    ------
    UserError
        The file cannot be read, or its header is whole and yet no run's.
    """
    reading = read_whole(path, most)
    records, more = checked(reading.records)
    reading.records = records
    reading.damage = sorted([*reading.damage, *more], key=_line)
    usable = bool(records) and records[0].kind == "header"
    return plan_from(records[0]) if usable else None, reading


def holds_records(path: Path) -> bool:
    """Return whether a journal holds at least one record, whole or damaged.

    One that the machine left torn at its first record holds nothing: the run can be begun anew.
    """
    return has_begun(path) and bool(read_whole(path, most=1).records)


def _line(damage: Damage) -> int:
    return damage.line


def dataset_of(path: Path, plan: RunPlan) -> Path:
    """Return the folder of the data set that a journal lies in.

    Raises
    ------
    UserError
        The journal was renamed, or lies outside a data set: what it says and where it lies differ.
    """
    whole = path.resolve()
    expected = plan.journal_path(Path("DATASET"))
    if whole.parts[-3:] == expected.parts[-3:]:
        return whole.parent.parent.parent
    raise UserError(
        f"journal {path}: was written as {expected}; put it back under that name and folder"
    )


def is_mock(spec: str) -> bool:
    """Return whether a plate is simulated: a finger would feel nothing."""
    return spec.partition(":")[0] == "mock"


def last_markers(records: list[Record]) -> tuple[str, ...]:
    """Return where the run's markers went last: SPECs, as after ``--markers``."""
    told = [record.data["outputs"] for record in records if record.kind == "markers"]
    return tuple(told[-1]) if told else ()


def last_backup(records: list[Record]) -> Path | None:
    """Return the folder that the run's journal was last to be copied to."""
    told = [str(record.data["folder"]) for record in records if record.kind == "backup"]
    return Path(told[-1]) if told else None


def last_plate(records: list[Record]) -> str:
    """Return the SPEC of the plate that a run was last on."""
    specs = [r.data["plate_spec"] for r in records if r.kind in ("header", "resume")]
    return str(specs[-1])


def answered_by(records: list[Record]) -> str:
    """Return who answered: "person", "simulated" or "scripted"."""
    return str(records[0].data["answered_by"])


def consent_was_taken_back(records: list[Record]) -> bool:
    """Return whether the participant said no when they were asked again for their consent."""
    again = [r.data for r in records if r.kind == "answered_again"]
    given = [data["answer"]["value"] for data in again if data["what"]["name"] == CONSENT]
    return given[-1:] == ["no"]


def elapsed_s(records: list[Record]) -> float:
    """Return how far a run had come: the session's time at its last step."""
    return max((r.time_s for r in records if r.kind in ("header", "begin", "done")), default=0.0)


def latest_s(records: list[Record]) -> float:
    """Return the latest session time that a journal holds: none goes back behind it."""
    return max((record.time_s for record in records), default=0.0)


def is_complete(records: list[Record]) -> bool:
    """Return whether a run went on to its end."""
    return any(record.kind == "end" for record in records)
