"""Record why participants are manually excluded from the analysis.

The decisions about a participant are stored next to the participant's journals, in
``sourcedata/sub-<label>/excluded.json``, so that a withdrawal also removes them and a merge also
copies them. The file lists all decisions in order, and the last one applies. Each decision records
whether results had already been shown, because an exclusion made with knowledge of the results is
unplanned.
"""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

from pydantic import Field, TypeAdapter, ValidationError

from slipscale.experiments.dataset.files import write_file
from slipscale.faults import UserError
from slipscale.faults.folders import visible
from slipscale.faults.frozen_table import FrozenTable
from slipscale.faults.validation import in_words

RECORD = "excluded.json"
BY_HAND = "by hand"  # beginning of the reason for a manual exclusion
EVERY = Path("sourcedata", "sub-*", RECORD)


class Decision(FrozenTable):
    """Decision to exclude a participant, or to reverse an earlier exclusion."""

    excluded: bool
    reason: Annotated[str, Field(min_length=1, max_length=2000)]
    decided_utc: str
    results_seen: bool


DECISIONS = TypeAdapter(tuple[Decision, ...])


def excluded_by_hand(dataset: Path) -> Mapping[str, Decision]:
    """Return the last decision about each manually excluded participant, keyed by label.

    Raises
    ------
    UserError
        If a participant's decisions cannot be read.
    """
    last = {
        path.parent.name.removeprefix("sub-"): decisions(path)[-1]
        for path in visible(dataset, EVERY.as_posix())
    }
    return {label: decision for label, decision in last.items() if decision.excluded}


def decide(
    dataset: Path, participant: str, *, excluded: bool, reason: str, results_seen: bool
) -> None:
    """Record a decision to exclude a participant, or to reverse an earlier exclusion.

    Raises
    ------
    UserError
        If the participant has no data, if the decision would change nothing, if the reason is
        empty, or if the file cannot be read or written.
    """
    path = dataset / "sourcedata" / f"sub-{participant}" / RECORD
    if not path.parent.is_dir():
        raise UserError(
            "participant {participant}: {dataset} contains no data from this participant",
            participant=participant,
            dataset=dataset,
        )
    known = decisions(path) if path.exists() else ()
    if excluded == bool(known and known[-1].excluded):
        state = "already excluded" if excluded else "not excluded by hand"
        raise UserError(
            "participant {participant} is {state}", participant=participant, state=state
        )
    if not reason.strip():
        raise UserError("expected a reason, which is printed in the report")
    decision = Decision(
        excluded=excluded,
        reason=" ".join(reason.split()),
        decided_utc=datetime.now(UTC).isoformat(timespec="seconds"),
        results_seen=results_seen,
    )
    write_file(path, DECISIONS.dump_json((*known, decision), indent=2) + b"\n", durable=True)


def decisions(path: Path) -> tuple[Decision, ...]:
    """Return all decisions about a participant, oldest first.

    Raises
    ------
    UserError
        If the file cannot be read or does not contain a list of decisions.
    """
    try:
        found = DECISIONS.validate_json(path.read_bytes())
    except OSError as error:
        raise UserError(
            "{path}: cannot be read ({reason})", path=path, reason=error.strerror
        ) from None
    except ValidationError as error:
        raise UserError("{path}: {faults}", path=path, faults=in_words(error)) from None
    if not found:
        raise UserError(
            "{path}: the file is empty; expected at least one decision, or no file", path=path
        )
    return found
