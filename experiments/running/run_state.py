"""How far a run has come, and what to do where it is not the free one that was wanted."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Literal

from experiments.dataset.withdrawal import replacement, withdrawn
from experiments.journal.locks import is_being_written
from experiments.journal.reading import has_begun
from experiments.journal.run_record import is_complete, read_usable
from faults import UserError

if TYPE_CHECKING:
    from pathlib import Path

RunState = Literal["free", "running now", "interrupted", "complete", "damaged"]


def run_state(path: Path) -> RunState:
    """Return how far the run of a journal has come; "free" where it has not begun."""
    if is_being_written(path):
        return "running now"
    if not has_begun(path):
        return "free"
    _, reading = read_usable(path)
    if not reading.records:
        return "free"  # the machine died while writing its first record: it holds nothing
    if reading.damage:
        return "damaged"
    return "complete" if is_complete(reading.records) else "interrupted"


def participants(dataset: Path) -> list[str]:
    """Return the labels of a data set's participants and of those who withdrew, sorted."""
    folders = (dataset / "sourcedata").glob("sub-*")
    present = {folder.name.removeprefix("sub-") for folder in folders}
    return sorted(present.union(withdrawn(dataset)))


def check_alike(dataset: Path, participant: str) -> None:
    """Raise `UserError` where a participant is there under a label that means the same: 1 and 01.

    They would pass for two people. Some file systems also take a for A.
    """

    def plain(label: str) -> str:
        return label.casefold().lstrip("0")

    for label in withdrawn(dataset):
        if plain(label) == plain(participant):
            raise UserError(
                f"--participant {participant}: they withdrew from {dataset}, and their number is "
                f"not used again; who replaces them is participant {replacement(label)}"
            )
    for label in participants(dataset):
        if label != participant and plain(label) == plain(participant):
            raise UserError(
                f"--participant {participant}: there is a participant {label} already in "
                f"{dataset}; expected that label for the same person, another number for another"
            )


def remedy(path: Path, state: RunState) -> str:
    """Return what to do where a run is not free."""
    another = "name another participant, or a new --session or --run"
    remedies: dict[RunState, str] = {
        "running now": f"end it where it runs, or {another}",
        "interrupted": how_to_resume(path),
        "complete": another,
        "damaged": f"slipscale data verify says where; what is whole of it is used; {another}",
    }
    return remedies[state]


def how_to_resume(journal: Path) -> str:
    """Return the sentence that says how to go on with a run."""
    return f"To go on: slipscale resume {shlex.quote(str(journal))}"
