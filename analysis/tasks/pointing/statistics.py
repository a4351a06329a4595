"""Compute throughput and the regression of movement time on the index of difficulty.

The analysis follows ISO/TS 9241-411:2012 and Soukoreff and MacKenzie (2004, International Journal
of Human-Computer Studies 61, 751-789). A cell contains the movements of one participant with the
same feedback, distance and width, pooled across sessions. Movements that miss the target are
included. Cells with fewer than `FEWEST` movements, with identical positions, or with a mean
movement away from the target are counted, but not used for throughput and regressions.

The effective width is 4.133 (the square root of 2 pi e) times the standard deviation of the
selected positions along the movement; the effective distance is the mean of these positions. The
effective index of difficulty is log2(distance / width + 1) in bits (Shannon formulation). A
participant's throughput is the mean of effective index / movement time across cells.

A line, ``movement time = a + b * index``, is fitted to each participant's cells, using the nominal
distance and width. Means across participants have t-based intervals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.task_tables import by_task, task_trials
from slipscale.analysis.statistics.mean_over_participants import (
    EstimatedMean,
    MeanOverParticipants,
    estimated_mean,
    mean_over_participants,
)
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.regression import fit_lines
from slipscale.analysis.statistics.statistic import Family, Inputs, Named, Statistic
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.protocols.pointing import ON_TARGET, PLAIN
from slipscale.experiments.steps.questions.pointing import WIDTH_IN_SD

PLACES = ("start_x_mm", "start_y_mm", "target_x_mm", "target_y_mm")
SELECTED = ("selection_x_mm", "selection_y_mm")


def _along(frame: pd.DataFrame, _problems: Problems) -> pd.DataFrame:
    """Add ``moved_mm``, the movement along the axis from start to target, and ``hit``."""
    x, y, to_x, to_y, end_x, end_y = (
        pd.to_numeric(frame[name], errors="coerce").to_numpy(float) for name in (*PLACES, *SELECTED)
    )
    length = np.hypot(to_x - x, to_y - y)
    with np.errstate(invalid="ignore", divide="ignore"):
        moved = ((end_x - x) * (to_x - x) + (end_y - y) * (to_y - y)) / length
    feedback = frame["feedback"].where(frame["feedback"] != "", PLAIN)
    return frame.assign(
        moved_mm=moved, hit=(frame["selection"] == ON_TARGET).astype(float), feedback=feedback
    )


TRIALS = task_trials(
    "pointing",
    "movement",
    marks=("movement_time", "distance_mm", "width_mm", *SELECTED),
    numeric=("movement_time", "distance_mm", "width_mm"),
    words=("feedback", "selection", *PLACES, *SELECTED),
    columns=("feedback", "distance_mm", "width_mm", "movement_time", "moved_mm", "hit"),
    needed=("movement_time", "distance_mm", "width_mm", "moved_mm"),
    required=("selection", *PLACES),
    derive=_along,
)


FEWEST = 3
MeanOrReason = EstimatedMean | NotComputed
Gain = MeanOverParticipants | NotComputed


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """Movements of one participant with the same distance and width.

    Parameters
    ----------
    bits, effective_bits : float
        Nominal and effective index of difficulty.
    movement_time_s : float
        Mean movement time.
    """

    bits: float
    effective_bits: float
    movement_time_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PersonPointing:
    """Results of one participant in one condition; NaN if a value cannot be computed."""

    participant: str
    movements: int
    error_share: float
    movement_time_s: float
    throughput_bit_s: float
    intercept_s: float
    slope_s_per_bit: float
    cells: tuple[Cell, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FeedbackPointing:
    """Results for one feedback condition.

    Parameters
    ----------
    feedback : str
    movements, left_out : int
        Number of movements, and number of omitted cells.
    throughput_bit_s, movement_time_s, error_share : EstimatedMean or NotComputed
    intercept_s, slope_s_per_bit : EstimatedMean or NotComputed
        Regression of movement time on the index of difficulty.
    people : tuple of PersonPointing
    """

    feedback: str
    movements: int
    left_out: int
    throughput_bit_s: MeanOrReason
    movement_time_s: MeanOrReason
    error_share: MeanOrReason
    intercept_s: MeanOrReason
    slope_s_per_bit: MeanOrReason
    people: tuple[PersonPointing, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskPointing:
    """Results for one task.

    Parameters
    ----------
    task : str
    conditions : tuple of FeedbackPointing
        Conditions, starting with the condition without feedback.
    throughput_gain_bit_s, time_gain_s : MeanOverParticipants or NotComputed
        Mean within-participant difference, second condition minus first.
    """

    task: str
    conditions: tuple[FeedbackPointing, ...]
    throughput_gain_bit_s: Gain
    time_gain_s: Gain


def pointing(inputs: Inputs) -> tuple[TaskPointing, ...] | NotComputed:
    """Return the results for each task."""
    trials = inputs.data.of(TRIALS)
    if not len(trials):
        return NotComputed("no movements")
    confidence = inputs.data.choices.confidence
    return tuple(of_task(task, rows, confidence) for task, rows in by_task(trials))


def of_task(task: str, rows: pd.DataFrame, confidence: float) -> TaskPointing:
    """Return the results for a task's movements, which have the columns of `TRIALS`."""
    conditions = tuple(
        _condition(str(feedback), own, confidence)
        for feedback, own in rows.groupby("feedback", sort=True)
    )

    def gain(name: str) -> Gain:
        if len(conditions) != 2:  # noqa: PLR2004
            return NotComputed(f"two feedback conditions are required (found: {len(conditions)})")
        first, second = (
            {each.participant: float(getattr(each, name)) for each in condition.people}
            for condition in conditions
        )
        both = [second[who] - value for who, value in first.items() if who in second]
        return mean_over_participants(np.array(both, np.float64), confidence)

    return TaskPointing(
        task=task,
        conditions=conditions,
        throughput_gain_bit_s=gain("throughput_bit_s"),
        time_gain_s=gain("movement_time_s"),
    )


def _condition(feedback: str, rows: pd.DataFrame, confidence: float) -> FeedbackPointing:
    found = [_person(str(who), own) for who, own in rows.groupby(PARTICIPANT, observed=True)]
    people = tuple(each for each, _ in found)

    def mean(name: str, possible: tuple[float, float] = (-inf, inf)) -> MeanOrReason:
        values = np.array([getattr(each, name) for each in people], np.float64)
        return estimated_mean(values, confidence, possible)

    return FeedbackPointing(
        feedback=feedback,
        movements=len(rows),
        left_out=sum(left_out for _, left_out in found),
        throughput_bit_s=mean("throughput_bit_s", (0.0, inf)),
        movement_time_s=mean("movement_time_s", (0.0, inf)),
        error_share=mean("error_share", (0.0, 1.0)),
        intercept_s=mean("intercept_s"),
        slope_s_per_bit=mean("slope_s_per_bit"),
        people=people,
    )


def _person(who: str, rows: pd.DataFrame) -> tuple[PersonPointing, int]:
    """Return one participant's results, and the number of omitted cells."""
    cells, left_out = [], 0
    for _, own in rows.groupby(["distance_mm", "width_mm"], sort=True):
        width = WIDTH_IN_SD * float(np.std(own["moved_mm"], ddof=1)) if len(own) > 1 else 0.0
        moved_mm = float(own["moved_mm"].mean())
        ratio = float((own["distance_mm"] / own["width_mm"]).iloc[0])
        if len(own) < FEWEST or not width or moved_mm <= 0:
            left_out += 1
            continue
        cells.append(
            Cell(
                bits=float(np.log2(ratio + 1)),
                effective_bits=float(np.log2(moved_mm / width + 1)),
                movement_time_s=float(own["movement_time"].mean()),
            )
        )
    line = fit_lines(_of(cells, lambda c: c.bits), _of(cells, lambda c: c.movement_time_s))
    rates = _of(cells, lambda c: c.effective_bits / c.movement_time_s)
    return PersonPointing(
        participant=who,
        movements=len(rows),
        error_share=float(1 - rows["hit"].mean()),
        movement_time_s=float(rows["movement_time"].mean()),
        throughput_bit_s=float(rates.mean()) if len(rates) else float("nan"),
        intercept_s=float(line.intercept),
        slope_s_per_bit=float(line.slope),
        cells=tuple(cells),
    ), left_out


def _of(cells: list[Cell], value: Callable[[Cell], float]) -> NDArray[np.float64]:
    return np.array([value(each) for each in cells], np.float64)


class _Pointing(Statistic[tuple[TaskPointing, ...]]):
    key = "pointing"
    meaning = "pointing: throughput, and movement time by index of difficulty"
    families = (
        Family(
            name="effect of feedback, t tests of throughput and of movement time",
            read=lambda tasks: [
                gain.p
                for task in tasks
                for gain in (task.throughput_gain_bit_s, task.time_gain_s)
                if gain
            ],
        ),
    )
    methods = (
        "Pointing throughput is the mean of the effective index of difficulty (Shannon "
        "formulation) divided by movement time [[soukoreff2004]], with an effective width of 4.133 "
        "standard deviations of the selections along the movement."
    )
    conclusions = (
        Named("*.throughput_gain_bit_s.p", "{0}: throughput differs with feedback (t test)"),
        Named("*.time_gain_s.p", "{0}: movement time differs with feedback (t test)"),
    )
    headlines = (
        Named("*.conditions.1.throughput_bit_s.mean", "{0}: throughput, bit/s"),
        Named("*.throughput_gain_bit_s.mean", "{0}: throughput gain with feedback, bit/s"),
    )

    compute = staticmethod(pointing)


POINTING = _Pointing()
