"""Replay finished steps: check them against the protocol, and return the recorded answers."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from slipscale.experiments.journal.serialisation import answer_from, same_step, step_record
from slipscale.experiments.steps.replies import Adjusted, Answer
from slipscale.experiments.steps.steps import Explore, Present, Silence, Step
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.experiments.journal.journal import Journal
    from slipscale.experiments.journal.record import Record
    from slipscale.experiments.session.surface_state import SurfaceState

# Records after which a step restarts from the beginning.
BEGUN_ANEW = ("go_on", "retry")


class Past(NamedTuple):
    """A finished step: its first and last records, and the start of its successful attempt."""

    begun: Record
    began_s: float
    done: Record


def finished(records: list[Record]) -> list[Past]:
    """Return the finished steps in the records of a journal."""
    past: list[Past] = []
    for record in records:
        if record.kind == "begin":
            begun, began_s = record, record.time_s
        elif record.kind in BEGUN_ANEW:
            began_s = record.time_s
        elif record.kind == "done":
            past.append(Past(begun=begun, began_s=began_s, done=record))
    return past


def replay(step: Step, past: Past, journal: Journal, surface: SurfaceState) -> Answer:
    """Return a step's answer from the journal, and update the surface accordingly.

    Raises
    ------
    UserError
        If the step differs from the recorded step.
    """
    if not same_step(past.begun.data["what"], step_record(step)):
        raise UserError(
            "journal {journal_path}, line {done_number}: the protocol's next step differs from "
            "the recorded step; resume with the version of Slipscale that began the run (the "
            "journal's first line names it)",
            journal_path=journal.path,
            done_number=past.done.number + 1,
        )
    answer = answer_from(past.done.data["answer"])
    if isinstance(step, Present):
        surface.presented(step, past.began_s)
    elif isinstance(step, Explore):
        surface.explored(step)
    elif isinstance(step, Silence):
        surface.silenced(step)
    elif isinstance(answer, Adjusted) and (wanted := surface.wanted):
        surface.adjusted(wanted.turned(answer.trace[-1][1]))
    return answer
