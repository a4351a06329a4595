"""Collect the records of a journal into trials."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from slipscale.experiments.dataset.measured import Explorations, of_interval, plate_measures
from slipscale.experiments.dataset.schema import (
    DAMAGED,
    FAULT,
    PAUSED,
    REPRESENTED,
    RESUMED,
    SENSOR,
    TIMED_OUT,
    UNCHANGED,
    VOIDED,
)
from slipscale.experiments.journal import reading
from slipscale.experiments.journal.record import Record
from slipscale.experiments.journal.serialisation import (
    surface_from,
    trial_from,
)
from slipscale.experiments.steps.columns import IntervalRecord, TrialRecord
from slipscale.experiments.steps.trial import Value
from slipscale.experiments.study.stroke import WITHIN

# Flag in a trial's row for each event during the trial. Resuming a pilot sets no flag, because no
# virtual time has passed.
EVENT_FLAGS: dict[str, str] = {
    "fault": FAULT,
    "pause": PAUSED,
    "represented": REPRESENTED,
    "take_up": RESUMED,
}
# The last step of each type and interval.
Steps = dict[tuple[str, int | None], dict[str, Any]]


@dataclass(slots=True)
class Gathered:
    """The content of a journal, grouped by trial.

    Parameters
    ----------
    person : dict
        Answers about the participant.
    run_answers : dict of dict
        Answers about a task as a whole, keyed by task.
    trials : dict of list
        Finished trials in order, keyed by task.
    voided : list
        Task, trial number and reason for each voided trial.
    """

    person: dict[str, Value] = field(default_factory=dict)
    run_answers: dict[str, dict[str, Value]] = field(default_factory=dict)
    trials: dict[str, list[TrialRecord]] = field(default_factory=dict)
    voided: list[tuple[str, int, str]] = field(default_factory=list)

    def measured(self, task: str) -> list[str]:
        """Return the names of the quantities measured in a task's trials."""
        return sorted({name for trial in self.trials.get(task, []) for name in trial.measured})


def gather(records: list[Record]) -> Gathered:
    """Return a run's trials and answers, collected from its journal's records in order.

    A trial that did not end is omitted, because the run was interrupted during the trial. If a
    surface was presented again, its row describes the last presentation, which was rated. If a
    record is damaged, the current trial and the next trial are flagged, because the record may
    belong to either trial.
    """
    gathered = Gathered()
    current: TrialRecord | None = None
    step: dict[str, Any] = {}
    last: Steps = {}
    explorations = Explorations()
    virtual = damage = False
    for record in records:
        explorations.see(record)
        if record.kind == "begin":
            step = record.data["what"]
            before, current = current, _trial(step, current, record.time_s)
            _flag_damaged(gathered, before, current, damage=damage, time_s=record.time_s)
            damage = damage and current is None
            last[step["type"], step.get("interval")] = step
        elif record.kind == "done":
            _answer(gathered, current, step, record)
            _measure(current, step, explorations)
            if step["type"] == "EndTrial":
                current = None
        elif record.kind == "answered_again":
            _answer(gathered, None, record.data["what"], record)
        elif record.kind == "stroke":
            explorations.outcome = " ".join(record.data["outside"]) or WITHIN
        elif record.kind == reading.DAMAGED:
            damage = True
        elif record.kind in EVENT_FLAGS:
            # Presentations that are repeated because a pilot was resumed set no flag either.
            virtual = record.data.get("virtual", virtual and record.kind == "represented")
            if current and not virtual:
                _flag(current, EVENT_FLAGS[record.kind])
                _take_again(current, last, record)
    voids = [record.data for record in records if record.kind == "void"]
    gathered.voided += [(void["task"], void["trial"], void["reason"]) for void in voids]
    _flag_voided(gathered)
    return gathered


def _flag_damaged(
    gathered: Gathered,
    before: TrialRecord | None,
    current: TrialRecord | None,
    *,
    damage: bool,
    time_s: float,
) -> None:
    """Flag the trials before and after damaged records, and end a trial whose end was lost."""
    if not damage:
        return
    if current:
        _flag(current, DAMAGED)
    if before and before is not current:
        _flag(before, DAMAGED)
        _end(gathered, before, time_s)


def _flag_voided(gathered: Gathered) -> None:
    for task, trial, _ in gathered.voided:
        for row in gathered.trials.get(task, []):
            if row.trial.number == trial:
                _flag(row, VOIDED)


def _trial(step: dict[str, Any], current: TrialRecord | None, time_s: float) -> TrialRecord | None:
    """Return the trial of a step: the current trial, a new trial, or None outside trials."""
    if not step["trial"]:
        return None
    trial = trial_from(step["trial"])
    if current and (current.trial.task, current.trial.number) == (trial.task, trial.number):
        return current
    return TrialRecord(trial=trial, onset_s=time_s)


def _flag(row: TrialRecord, flag: str) -> None:
    if flag not in row.flags:
        row.flags.append(flag)


def _answer(
    gathered: Gathered, row: TrialRecord | None, step: dict[str, Any], record: Record
) -> None:
    """Store an answer in its trial's row, or with the answers about the task or participant."""
    answer = record.data["answer"] or {}
    if row is not None:
        take = TAKERS.get(step["type"])
        if take:
            take(row, step, answer)
        if step["type"] == "EndTrial":
            _end(gathered, row, record.time_s)
    elif step["type"] == "Ask" and step["task"]:
        gathered.run_answers.setdefault(step["task"], {})[step["name"]] = answer["value"]
    elif step["type"] == "Ask":
        gathered.person[step["name"]] = answer["value"]


def _take_again(row: TrialRecord, last: Steps, record: Record) -> None:
    """Let a row describe a repeated presentation, unless damage hides the first presentation."""
    if record.kind != "represented":
        return
    step = last.get(("Present", record.data.get("interval")))
    answer = record.data.get("answer")
    if step and answer and step["trial"] and trial_from(step["trial"]) == row.trial:
        _take_presented(row, step, answer)


def _measure(row: TrialRecord | None, step: dict[str, Any], explorations: Explorations) -> None:
    """Add the measures of a finished exploration to the row of its trial."""
    if row and step["type"] == "Explore":
        found = of_interval(explorations.measures(), step.get("interval"))
        row.measured = {**row.measured, **found}
        if explorations.implausible():
            _flag(row, SENSOR)
        if explorations.unchanged:
            _flag(row, UNCHANGED)


def _end(gathered: Gathered, row: TrialRecord, time_s: float) -> None:
    """Add a finished trial to its task."""
    task = row.trial.task
    row.end_s = time_s
    row.run_answers = gathered.run_answers.get(task, {})
    gathered.trials.setdefault(task, []).append(row)


def _take_presented(row: TrialRecord, step: dict[str, Any], answer: dict[str, Any]) -> None:
    surface = surface_from(step["surface"])
    row.measured = {**row.measured, **of_interval(plate_measures(answer), step.get("interval"))}
    if number := step.get("interval"):
        shown = row.intervals.setdefault(number, IntervalRecord(surface=surface))
        shown.readback_level, shown.onset_s = _read_back(answer), answer["onset_s"]
        if number != next(iter(row.intervals)):
            return  # the trial's surface and onset are those of its first interval
    row.surface = surface
    row.before = surface_from(step["lead_in"][0]["surface"]) if step["lead_in"] else None
    row.readback_level = _read_back(answer)
    row.onset_s = answer["onset_s"]


def _read_back(answer: dict[str, Any]) -> float | None:
    """Return the level that the plate measured or applied; None if it only repeats the command."""
    level: float | None = answer["readback_level"]
    return None if answer["readback_kind"] == "commanded" else level


def _take_exploration(row: TrialRecord, step: dict[str, Any], answer: dict[str, Any]) -> None:
    number = step.get("interval")
    if number is None:
        row.exploration_time_s = answer["response_time_s"]
    elif number in row.intervals:
        row.intervals[number].exploration_time_s = answer["response_time_s"]
    else:  # the explored surface is unknown, because the record of the presentation was lost
        _flag(row, DAMAGED)


def _take_answer(row: TrialRecord, step: dict[str, Any], answer: dict[str, Any]) -> None:
    row.answers[step["name"]] = answer
    if answer["timed_out"]:
        _flag(row, TIMED_OUT)


def _take_adjusted(row: TrialRecord, step: dict[str, Any], answer: dict[str, Any]) -> None:
    """Store an adjustment; its readback counts only if the trial's presentation was read back."""
    if row.readback_level is None:
        answer = {**answer, "readback_level": None}
    _take_answer(row, step, answer)


TAKERS: dict[str, Callable[[TrialRecord, dict[str, Any], dict[str, Any]], None]] = {
    "Present": _take_presented,
    "Explore": _take_exploration,
    "Ask": _take_answer,
    "Adjust": _take_adjusted,
}
