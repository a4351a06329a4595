"""How far a run has come, and what to do where it is not the free one that was wanted."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Literal

from experiments.journal import has_begun, is_being_written
from experiments.run import is_complete, read_plan

if TYPE_CHECKING:
    from pathlib import Path

RunState = Literal["free", "running now", "interrupted", "complete"]


def run_state(path: Path) -> RunState:
    """Return how far the run of a journal has come; "free" where it has not begun."""
    if is_being_written(path):
        return "running now"
    if not has_begun(path):
        return "free"
    return "complete" if is_complete(read_plan(path)[1]) else "interrupted"


def remedy(path: Path, state: RunState) -> str:
    """Return what to do where a run is not free."""
    another = "name another participant, or a new --session or --run"
    remedies: dict[RunState, str] = {
        "running now": f"end it where it runs, or {another}",
        "interrupted": to_go_on(path),
        "complete": another,
    }
    return remedies[state]


def to_go_on(journal: Path) -> str:
    """Return the sentence that says how to go on with a run."""
    return f"To go on: slipscale resume {shlex.quote(str(journal))}"
