"""Simulate answers in choice and ratio tasks, in the format that `analyse` reads.

Simulated participants complete the real protocol without plate, screen or files. Simulated data are
built and read with the same code as real data.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pandas as pd

from slipscale.analysis.planning.protocols.studies import RATIO, ProtocolStudy, minutes_of
from slipscale.analysis.statistics.psychometrics.psychometric_function import Answers
from slipscale.analysis.statistics.regression import fit_lines
from slipscale.analysis.tasks.thresholds.reading import told_choices
from slipscale.experiments.dataset.rows_from_journal import gather
from slipscale.experiments.dataset.schema import INTERVAL, MAIN
from slipscale.experiments.journal.record import Record
from slipscale.experiments.journal.serialisation import answer_record, step_record
from slipscale.experiments.participants.simulated_people.bare_run import (
    BareStep,
    bare_run,
    drops_out,
)
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.steps.steps import Ask, EndTrial, Present
from slipscale.experiments.study.run_plan import RunPlan

#: Types of steps from which the rows of a task's table are built.
TOLD = (Present, Ask, EndTrial)


class Answered(NamedTuple):
    """A simulated person's main-trial data: choices, or an exponent fitted to ratio judgements."""

    method: str
    answers: Answers | None = None
    exponent: float = math.nan


class StudyAnswers(NamedTuple):
    """Answers of each person in a simulated study (None without answers), and durations."""

    people: list[Answered | None]
    minutes: list[float]


def answers_of(
    study: ProtocolStudy, participants: int, seed: int, population: Population
) -> StudyAnswers:
    """Simulate one study and return its answers."""
    rows, minutes = rows_of(study, participants, seed, population)
    return StudyAnswers([read_answers(study, own) for own in rows], minutes)


def rows_of(
    study: ProtocolStudy, participants: int, seed: int, population: Population
) -> tuple[list[pd.DataFrame], list[float]]:
    """Simulate one study; return each person's main trials and total minutes."""
    rows: dict[str, list[pd.DataFrame]] = {}
    minutes: dict[str, float] = {}
    for plan in study.plans(participants, seed, population):
        if plan.visit and drops_out(plan, population):
            continue  # People who dropped out take no part in later sessions.
        steps = list(bare_run(plan, population))
        who = plan.participant
        minutes[who] = minutes.get(who, 0.0) + minutes_of(steps)
        rows.setdefault(who, []).append(_rows(study, plan, steps))
    everybody = [pd.concat(own, ignore_index=True) for own in rows.values()]
    return everybody, list(minutes.values())


def _rows(study: ProtocolStudy, plan: RunPlan, steps: list[BareStep]) -> pd.DataFrame:
    """Return the main trials of a run as rows of the task's table."""
    protocol = next(each for each, _ in plan.tasks() if each.task == study.task)
    trials = gather(_records(steps)).trials.get(study.task, [])
    main = [trial for trial in trials if trial.trial.phase == MAIN]
    columns = {**protocol.design, **protocol.stimulus, **protocol.response}
    found = {name: [each.value(trial) for trial in main] for name, each in columns.items()}
    third = f"{INTERVAL}3_surface"
    return pd.DataFrame(
        {**found, "task": study.task, third: [trial.intervals.get(3) for trial in main]}
    )


def _records(steps: list[BareStep]) -> list[Record]:
    """Convert steps to journal records."""
    found: list[Record] = []
    for done in steps:
        if isinstance(done.step, TOLD):
            began = {"what": step_record(done.step)}
            ended = {"answer": answer_record(done.answer)}
            found.append(Record(number=len(found), time_s=0.0, kind="begin", data=began))
            found.append(Record(number=len(found), time_s=0.0, kind="done", data=ended))
    return found


def read_answers(study: ProtocolStudy, rows: pd.DataFrame) -> Answered | None:
    """Parse a person's answers, or return None if there are none."""
    if rows.empty or study.marks is None:
        return None
    if study.marks == RATIO:
        return Answered("ratio", exponent=_exponent(rows))
    frame = rows.rename(columns={study.marks[0]: "track_level"})
    frame = told_choices(frame.astype({"track_level": float}), study.marks)
    main = frame[frame["correct"].notna() & frame["track_level"].notna() & ~frame["catch"]]
    if main.empty:
        return None
    method = str(main["method"].iloc[0])
    levels, correct = main["track_level"].tolist(), main["correct"].astype(bool).tolist()
    return Answered(method, Answers.of_trials(levels, correct))


def _exponent(rows: pd.DataFrame) -> float:
    """Return the slope of mean log ratios against log amplitude, as for magnitude estimates."""
    amplitude, ratio = RATIO
    usable = rows[(rows["catch"] != "true") & (rows[amplitude] > 0) & rows[ratio].notna()]
    logs = usable[ratio].astype(float).map(math.log)
    means = logs.groupby(usable[amplitude].astype(float)).mean()
    return float(fit_lines(np.log(means.index.to_numpy()), means.to_numpy()).slope)
