"""What is not as it was in the last run of a data set: study, plate, the computer's date.

Each can be meant. Nobody should find out after ten more participants, so `check` reports it, and
`run` and `next` ask.
"""

from __future__ import annotations

from datetime import UTC, datetime
from typing import TYPE_CHECKING

from slipscale.experiments.dataset.journals import journals
from slipscale.experiments.journal.plan_and_progress import read_usable
from slipscale.hardware.address import with_plate_file

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from slipscale.experiments.journal.record import Record
    from slipscale.experiments.study.model import Study
    from slipscale.experiments.study.run_plan import RunPlan


def changes(dataset: Path, study: Study, text: str, plate: str) -> Iterator[str]:
    """Yield a sentence for each thing that changed since earlier runs of a study.

    Parameters
    ----------
    dataset : Path
        Its journals' first records are read.
    study : Study
        The study that is to be run.
    text : str
        Its file's text.
    plate : str
        The plate's SPEC as the command names it.
    """
    begun = [found for path in journals(dataset) if (found := _begun(path, study.name))]
    other = sorted({plan.stem for plan, _ in begun if plan.study_text != text})
    if other:
        yield (
            f"the study '{study.name}' has changed since {', '.join(other)}: give the new one "
            "another name or another folder, unless the change is meant"
        )
    if not begun:
        return
    last, header = max(begun, key=lambda each: (str(each[1].data["started_utc"]), each[0].stem))
    spec = with_plate_file(plate, study.plate.file)
    was = str(header.data["plate_spec"])
    if was != spec:
        yield f"the plate was '{was}' in {last.stem}, and is '{spec}' now"
    now = datetime.now(UTC)
    try:
        then = datetime.fromisoformat(str(header.data["started_utc"])).astimezone(UTC)
    except ValueError:  # a date that is none tells nothing
        return
    if now < then:
        yield (
            f"this computer's date, {now:%Y-%m-%d %H:%M} UTC, is before the beginning of "
            f"{last.stem}, {then:%Y-%m-%d %H:%M} UTC: set the clock"
        )


def _begun(path: Path, study: str) -> tuple[RunPlan, Record] | None:
    """Return the plan and header of a study's run; None for any other journal."""
    plan, reading = read_usable(path, most=1)
    return (plan, reading.records[0]) if plan and plan.study.name == study else None
