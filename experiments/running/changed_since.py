"""Report changes in the study, the plate and the computer's date since a data set's last run.

Because a change may be unintended, `check` reports all changes, and `run` and `next` ask for
confirmation.
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from slipscale.experiments.dataset.journals import journals
from slipscale.experiments.journal.plan_and_progress import read_usable
from slipscale.experiments.journal.record import Record
from slipscale.experiments.study.model import Study
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.hardware.address import with_plate_file


def changes(dataset: Path, study: Study, text: str, plate: str) -> Iterator[str]:
    """Yield a description of each change since the earlier runs of a study.

    Parameters
    ----------
    dataset : Path
        Data set with the earlier runs. Only the first record of each journal is read.
    study : Study
        The study to be run.
    text : str
        Text of the study file.
    plate : str
        Specification (SPEC) of the plate, as given to the command.
    """
    begun = [found for path in journals(dataset) if (found := _begun(path, study.name))]
    other = sorted({plan.stem for plan, _ in begun if plan.study_text != text})
    if other:
        yield (
            f"the study '{study.name}' has changed since {', '.join(other)}: unless the "
            "change is intended, give the new study another name or use another folder"
        )
    if not begun:
        return
    last, header = max(begun, key=lambda each: (str(each[1].data["started_utc"]), each[0].stem))
    spec = with_plate_file(plate, study.plate.file)
    was = str(header.data["plate_spec"])
    if was != spec:
        yield f"the plate was '{was}' in {last.stem}, but is now '{spec}'"
    now = datetime.now(UTC)
    try:
        then = datetime.fromisoformat(str(header.data["started_utc"])).astimezone(UTC)
    except ValueError:  # an invalid date is ignored
        return
    if now < then:
        yield (
            f"this computer's clock shows {now:%Y-%m-%d %H:%M} UTC, but {last.stem} began at "
            f"{then:%Y-%m-%d %H:%M} UTC; set the clock"
        )


def _begun(path: Path, study: str) -> tuple[RunPlan, Record] | None:
    """Return the plan and header of a run; None if the journal belongs to a different study."""
    plan, reading = read_usable(path, most=1)
    return (plan, reading.records[0]) if plan and plan.study.name == study else None
