"""Every trial of a run with its levels and answers, which unblind the viewer.

The console shows them for rehearsals and pilots only.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from slipscale.experiments.dataset.rows_from_journal import gather
from slipscale.experiments.dataset.schema import PRACTICE
from slipscale.experiments.journal.plan_and_progress import read_usable
from slipscale.experiments.steps.columns import TrialRecord
from slipscale.experiments.steps.trial import Value
from slipscale.faults import UserError
from slipscale.stimuli.quantity import Quantity
from slipscale.stimuli.surface import Stimulus


@dataclass(frozen=True, slots=True, kw_only=True)
class AnsweredTrial:
    """A trial with what was presented and what was answered.

    Parameters
    ----------
    presented : tuple of str
        Levels with their unit, or names of textures, in the order of presentation.
    answers : tuple of values
        Answers in the order of the questions, without unanswered questions.
    """

    task: str
    number: int
    practice: bool
    presented: tuple[str, ...]
    answers: tuple[Value, ...]
    flags: tuple[str, ...] = ()


def answered_trials(journal: Path, quantity: Quantity) -> list[AnsweredTrial]:
    """Return the trials of a run, task by task; empty if the journal cannot be read."""
    try:
        _, reading = read_usable(journal)
    except (OSError, UserError):
        return []
    trials = gather(reading.records).trials
    return [_answered(trial, quantity) for task in trials.values() for trial in task]


def _answered(record: TrialRecord, quantity: Quantity) -> AnsweredTrial:
    surfaces: list[Stimulus | None] = [each.surface for _, each in sorted(record.intervals.items())]
    surfaces = surfaces or [record.before, record.surface]
    given = [answer.get("value") for answer in record.answers.values()]
    return AnsweredTrial(
        task=record.trial.task,
        number=record.trial.number,
        practice=record.trial.phase == PRACTICE,
        presented=tuple(_shown(surface, quantity) for surface in surfaces if surface),
        answers=tuple(value for value in given if value is not None),
        flags=tuple(record.flags),
    )


def _shown(surface: Stimulus, quantity: Quantity) -> str:
    return surface.name or quantity.value(surface.settled_level)
