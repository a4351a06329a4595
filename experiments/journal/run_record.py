"""What a run's journal says of the run itself: its plan, plate, software and how far it came."""

from __future__ import annotations

import platform
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from experiments.journal.journal import FORMAT, read_records
from experiments.study.file import study_hash
from experiments.study.run_plan import RunPlan
from faults import UserError

if TYPE_CHECKING:
    from experiments.journal.journal import Record
    from hardware.driver import PlateDriver

PACKAGES = ("slipscale", "numpy", "psychopy")


def header(
    plan: RunPlan, plate: PlateDriver, spec: str, answered_by: str, masking: str
) -> dict[str, Any]:
    """Return the journal's first record: all that is needed to resume or to analyse."""
    return {
        "format": FORMAT,
        **asdict(plan),
        "answered_by": answered_by,
        "masking_noise": masking,
        "study_hash": study_hash(plan.study_text),
        "plate_spec": spec,
        "plate": plate.describe(),
        "software": software(),
        "started_utc": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def software() -> dict[str, str]:
    """Return the versions of what a run's data can depend on, without importing it."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found


def plan_from(record: Record) -> RunPlan:
    """Return the plan that a journal's header holds."""
    # Journals written before orders had a version were drawn with the first.
    data = {"order_version": 1, **record.data}
    return RunPlan(**{name: data[name] for name in RunPlan.__dataclass_fields__})


def read_plan(path: Path) -> tuple[RunPlan, list[Record]]:
    """Return a journal's plan and records; UserError unless it is a run's."""
    records, _ = read_records(path)
    if not records:
        raise UserError(f"journal {path}: holds nothing; begin the run anew with slipscale run")
    return plan_from(records[0]), records


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


def last_plate(records: list[Record]) -> str:
    """Return the SPEC of the plate that a run was last on."""
    specs = [r.data["plate_spec"] for r in records if r.kind in ("header", "resume")]
    return str(specs[-1])


def answered_by(records: list[Record]) -> str:
    """Return who answered: "person", "simulated" or "scripted"."""
    return str(records[0].data["answered_by"])


def elapsed_s(records: list[Record]) -> float:
    """Return how far a run had come: the session's time at its last step."""
    return max((r.time_s for r in records if r.kind in ("header", "begin", "done")), default=0.0)


def is_complete(records: list[Record]) -> bool:
    """Return whether a run went on to its end."""
    return any(record.kind == "end" for record in records)
