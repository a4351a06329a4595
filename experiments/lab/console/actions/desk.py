"""The state that all actions share: laboratory folder, started jobs and session warnings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipscale.experiments.lab.console.actions.forms import Form
from slipscale.experiments.lab.console.jobs import USING_THE_PLATE, Jobs
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.experiments.lab.console.state import Snapshot, State


class Warnings:
    """Session warnings that have not been acknowledged, as (session, message) pairs."""

    def __init__(self, state: State, jobs: Jobs) -> None:
        self._state = state
        self._jobs = jobs
        self._found: dict[tuple[str, str], None] = {}  # in order of occurrence
        self._acknowledged: set[tuple[str, str]] = set()

    def pending(self) -> list[tuple[str, str]]:
        """Return the warnings that have not been acknowledged."""
        live, job = self._state.now().live, self._jobs.last("session")
        if live and live.status:
            found = [(live.status.token, sentence) for sentence in live.status.warnings]
            self._found |= dict.fromkeys(found)
        if job:
            self._found |= dict.fromkeys((str(job.began_s), each) for each in job.warnings())
        return [each for each in tuple(self._found) if each not in self._acknowledged]

    def acknowledge(self, session: str, sentence: str) -> None:
        """Acknowledge a warning, so that it is no longer shown."""
        self._acknowledged.add((session, sentence))


class Desk:
    """The console's state, jobs and warnings, which all actions share.

    Parameters
    ----------
    state : State
    jobs : Jobs

    Attributes
    ----------
    analysed : frozenset
        Complete runs included in the last analysis started by this console.
    """

    def __init__(self, state: State, jobs: Jobs) -> None:
        self.state = state
        self.jobs = jobs
        self.warnings = Warnings(state, jobs)
        self.analysed: frozenset[tuple[Path, int]] = frozenset()

    def now(self) -> Snapshot:
        """Return a new snapshot of the folder; raise `UserError` if the folder cannot be used."""
        found = self.state.now(fresh=True)
        if found.problem:
            raise UserError(found.problem)
        return found

    def free(self) -> Snapshot:
        """Return a new snapshot of the folder if the plate is free; otherwise raise `UserError`."""
        found = self.now()
        self.check_free(found)
        return found

    def check_free(self, found: Snapshot) -> None:
        """Raise `UserError` if the plate is in use."""
        if found.live:
            raise UserError(
                "a session of participant {live_label} is running; end it first",
                live_label=found.live.label,
            )
        for kind in USING_THE_PLATE:
            job = self.jobs.last(kind)
            if job and job.running:
                raise UserError(
                    "{about}: still running; wait until it is finished", about=job.about
                )


# The form of each action and the function that carries out the action, keyed by the action's name.
Actions = Mapping[str, tuple[type[Form], Callable[[Desk, Any], str]]]
