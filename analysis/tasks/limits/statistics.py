"""Estimate thresholds by the method of limits.

A series has a transition if its last answer differs from the earlier answers. The transition lies
halfway between the last level and the nearest earlier level in the direction of the series. Series
without a transition are omitted and counted.

A participant's threshold is the mean of the mean ascending and the mean descending transition, so
that both directions have equal weight. The constant error is the descending minus the ascending
transition. Noise alone makes it positive (see `expected_difference`). An error above the expected
one means that answers change too early (anticipation); an error below it means that they change too
late (habituation).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from slipscale.analysis.reading.answer_codes import own_answers
from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.task_tables import by_task, task_trials
from slipscale.analysis.statistics.mean_over_participants import (
    EstimatedMean,
    MeanOverParticipants,
    estimated_mean,
    mean_over_participants,
)
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Family, Inputs, Named, Statistic
from slipscale.analysis.tasks.limits.expected_difference import Series, noise_alone
from slipscale.experiments.dataset.schema import PARTICIPANT

ASCENDING, DESCENDING = "ascending", "descending"
#: Share of series without a transition above which anticipation and habituation are not tested. The
#: levels then do not cover the threshold. Such studies without either gave p < .05 in .26 (people
#: who feel all levels alike) to .86 (people who feel the lowest level; `benchmarks.truths`).
MOST_WITHOUT = 1 / 3


def _coded(frame: pd.DataFrame, _problems: Problems) -> pd.DataFrame:
    return frame.assign(felt=own_answers(frame["different"]))


TRIALS = task_trials(
    "limits",
    "the method of limits",
    marks=("series", "direction", "comparison_level", "different"),
    numeric=("series", "comparison_level", "standard_level"),
    words=("different",),
    codes={"direction": (ASCENDING, DESCENDING)},
    columns=("series", "direction", "comparison_level", "standard_level", "felt"),
    needed=("felt", "comparison_level", "series"),
    levels=("comparison_level", "standard_level"),
    derive=_coded,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class PersonLimits:
    """Mean transition of one participant in each direction; NaN if there is no transition."""

    participant: str
    ascending_level: float
    descending_level: float
    threshold_level: float
    transitions: int


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskLimits:
    """Results for one task.

    Parameters
    ----------
    task : str
    participants, answers, series, without_transition : int
        Counts of participants, answers, series, and series without a transition.
    standard_level : float or None
        Level of the standard; None if it was not constant.
    threshold_level, ascending_level, descending_level : EstimatedMean or NotComputed
    constant_error_level : EstimatedMean or NotComputed
        Mean difference across participants, descending minus ascending transition. It has no test,
        because noise alone makes it positive.
    spread_level, expected_error_level : float
        Common standard deviation of sensations, and mean difference that it causes.
    unexpected_error_level : MeanOverParticipants or NotComputed
        Mean difference across participants minus the difference expected for each of them, with
        the test of anticipation and habituation.
    people : tuple of PersonLimits
    """

    task: str
    participants: int
    answers: int
    series: int
    without_transition: int
    standard_level: float | None
    threshold_level: EstimatedMean | NotComputed
    ascending_level: EstimatedMean | NotComputed
    descending_level: EstimatedMean | NotComputed
    constant_error_level: EstimatedMean | NotComputed
    spread_level: float
    expected_error_level: float
    unexpected_error_level: MeanOverParticipants | NotComputed
    people: tuple[PersonLimits, ...]


def transition_level(rows: pd.DataFrame) -> float:
    """Return the transition in a series of rows in order of presentation, or NaN without one."""
    rising = rows["direction"].iloc[0] == ASCENDING
    last, ended = float(rows["comparison_level"].iloc[-1]), bool(rows["felt"].iloc[-1]) is rising
    levels = rows["comparison_level"].to_numpy(float)
    before = levels[levels < last] if rising else levels[levels > last]
    if not ended or not len(before):
        return float("nan")
    return (last + float(before.max() if rising else before.min())) / 2


def limits(inputs: Inputs) -> tuple[TaskLimits, ...] | NotComputed:
    """Return the thresholds for each task."""
    trials = inputs.data.of(TRIALS)
    if not len(trials):
        return NotComputed("no trials of the method of limits")
    confidence = inputs.data.choices.confidence
    return tuple(_task(task, rows, confidence) for task, rows in by_task(trials))


def _task(task: str, rows: pd.DataFrame, confidence: float) -> TaskLimits:
    by = [PARTICIPANT, "session", "run", "series"]
    whose: dict[str, dict[str, list[float]]] = {}
    found: list[float] = []
    every: list[Series] = []
    for (who, *_), series in rows.sort_values("trial").groupby(by, observed=True, sort=True):
        transition = transition_level(series)
        found.append(transition)
        own = whose.setdefault(str(who), {ASCENDING: [], DESCENDING: []})
        if np.isfinite(transition):
            own[str(series["direction"].iloc[0])].append(transition)
        every.append(
            Series(
                who=len(whose) - 1,
                rising=bool(series["direction"].iloc[0] == ASCENDING),
                levels=series["comparison_level"].to_numpy(float),
                felt=series["felt"].to_numpy(float),
            )
        )
    expected = noise_alone(every, len(whose))
    without = int(np.isnan(found).sum())
    people = tuple(_person(who, own) for who, own in whose.items())
    up, down, threshold = (
        np.array([getattr(each, f"{name}_level") for each in people], np.float64)
        for name in (ASCENDING, DESCENDING, "threshold")
    )
    standards = rows["standard_level"].dropna().unique()
    return TaskLimits(
        task=task,
        participants=len(people),
        answers=len(rows),
        series=len(found),
        without_transition=without,
        standard_level=float(standards[0]) if len(standards) == 1 else None,
        threshold_level=estimated_mean(threshold, confidence),
        ascending_level=estimated_mean(up, confidence),
        descending_level=estimated_mean(down, confidence),
        constant_error_level=estimated_mean(down - up, confidence),
        spread_level=expected.spread_level,
        expected_error_level=float(np.mean(expected.difference_level[np.isfinite(down - up)]))
        if np.isfinite(down - up).any()
        else float("nan"),
        unexpected_error_level=mean_over_participants(
            down - up - expected.difference_level, confidence
        )
        if without <= MOST_WITHOUT * len(found)
        else NotComputed(
            f"{without} of {len(found)} series had no transition, so the levels hardly show how "
            "answers depend on the level"
        ),
        people=people,
    )


def _person(who: str, own: dict[str, list[float]]) -> PersonLimits:
    up, down = (float(np.mean(own[way])) if own[way] else float("nan") for way in own)
    return PersonLimits(
        participant=who,
        ascending_level=up,
        descending_level=down,
        threshold_level=(up + down) / 2,
        transitions=sum(map(len, own.values())),
    )


class _Limits(Statistic[tuple[TaskLimits, ...]]):
    key = "limits"
    meaning = "method of limits: mean transitions, and constant error between directions"
    families = (
        Family(
            name="direction of series, t test of the constant error beyond noise",
            read=lambda tasks: [
                task.unexpected_error_level.p for task in tasks if task.unexpected_error_level
            ],
        ),
    )
    methods = (
        "Thresholds by the method of limits are means of the transitions in ascending and "
        "descending series, with equal weight for both directions. Noise alone ends descending "
        "series higher than ascending series. The difference between directions was therefore "
        "tested against the difference expected from cumulative normal functions with a threshold "
        "per participant and a common spread."
    )
    conclusions = (
        Named("*.unexpected_error_level.p", "{0}: anticipation or habituation (t test)"),
    )
    headlines = (Named("*.threshold_level.mean", "{0}: threshold by the method of limits"),)

    compute = staticmethod(limits)


LIMITS = _Limits()
