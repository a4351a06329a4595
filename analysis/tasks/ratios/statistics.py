"""Analyse ratio judgements against a standard: geometric means and exponent.

Ratios need no normalisation, because every participant's ratio for the standard is 1. All
computations use logarithms.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp

import numpy as np
import pandas as pd

from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.task_tables import above_zero, by_task, task_trials
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.mean_over_participants import mean_over_participants
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.power_law import PowerLaw, power_law_of
from slipscale.analysis.statistics.statistic import Inputs, Named, Statistic
from slipscale.experiments.dataset.schema import PARTICIPANT

JUDGED = ("ratio", "comparison_level", "standard_level")


def _ratios(frame: pd.DataFrame, problems: Problems) -> pd.DataFrame:
    return frame.assign(ratio=above_zero(frame["ratio"], "ratios", problems))


TRIALS = task_trials(
    "ratios",
    "ratio",
    marks=JUDGED,
    numeric=JUDGED,
    columns=JUDGED,
    needed=JUDGED,
    levels=JUDGED[1:],
    derive=_ratios,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class JudgedSurface:
    """Judged slipperiness of one surface, as a ratio to the standard.

    Parameters
    ----------
    comparison_level : float
        Amplitude in µm peak to peak.
    participants, judgements : int
        Counts of participants and judgements.
    ratio : float
        Geometric mean of participants' geometric means.
    interval : ConfidenceInterval or None
        t-based interval, computed on logarithms; None if not defined.
    """

    comparison_level: float
    participants: int
    judgements: int
    ratio: float
    interval: ConfidenceInterval | None


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskRatios:
    """Results for a ratio-judgement task.

    Parameters
    ----------
    task : str
        Task label, as in file names.
    standard_level : float
        Amplitude in µm peak to peak.
    name : str
        Name of the figure: the task label, followed by the standard in nm if the task has several
        standards.
    participants, answers, catch_trials : int
        Counts of participants, answers (without catch trials) and catch trials.
    catch_ratio : float or None
        Geometric mean ratio in catch trials, which compare the standard with itself.
    surfaces : tuple of JudgedSurface
        Surfaces in ascending order.
    power_law : PowerLaw or NotComputed
        Power law, fitted to each participant's log ratios and log amplitudes.
    """

    task: str
    standard_level: float
    name: str
    participants: int
    answers: int
    catch_trials: int
    catch_ratio: float | None
    surfaces: tuple[JudgedSurface, ...]
    power_law: PowerLaw | NotComputed


def ratios(trials: pd.DataFrame, confidence: float = 0.95) -> tuple[TaskRatios, ...] | NotComputed:
    """Return results for each ratio-judgement task and standard.

    Parameters
    ----------
    trials : DataFrame
        Trials as read by `slipscale.analysis.tasks.ratios.statistics.TRIALS`.
    """
    if not len(trials) or trials["catch"].all():
        return NotComputed("no ratio judgements")
    return tuple(
        _task(
            task,
            standard,
            rows[rows["standard_level"] == standard],
            name=task if len(standards) == 1 else f"{task}_{1000 * standard:.0f}nm",
            confidence=confidence,
        )
        for task, rows in by_task(trials)
        for standards in [sorted(rows.loc[~rows["catch"], "standard_level"].unique().tolist())]
        for standard in standards
    )


def log_cells(main: pd.DataFrame, by: str, value: str) -> pd.DataFrame:
    """Return mean natural logarithms of ``value``, by participant (rows) and ``by`` (columns)."""
    logs = main.assign(log=np.log(main[value].to_numpy(float)))
    return logs.pivot_table(index=PARTICIPANT, columns=by, values="log", observed=True)


def geometric(logs: pd.Series[float], confidence: float) -> tuple[float, ConfidenceInterval | None]:
    """Return the geometric mean across participants, and its interval if defined."""
    values = np.asarray(logs.dropna(), np.float64)
    found = mean_over_participants(values, confidence)
    if not found:
        return exp(values.mean()), None
    low, high = (exp(bound) for bound in found.interval)
    return exp(found.mean), replace(found.interval, low=low, high=high)


def catch_mean(catch: pd.DataFrame, value: str) -> float | None:
    """Return the geometric mean of the answers in catch trials, weighting participants equally."""
    if not len(catch):
        return None
    logs = catch.assign(log=np.log(catch[value].to_numpy(float)))
    return exp(logs.groupby(PARTICIPANT, observed=True)["log"].mean().mean())


def _task(
    task: str, standard: float, rows: pd.DataFrame, *, name: str, confidence: float
) -> TaskRatios:
    main, catch = rows[~rows["catch"]], rows[rows["catch"]]
    table = log_cells(main, "comparison_level", "ratio")
    surfaces = []
    for amplitude in table.columns:
        mean, interval = geometric(table[amplitude], confidence)
        surfaces.append(
            JudgedSurface(
                comparison_level=float(amplitude),
                participants=int(table[amplitude].notna().sum()),
                judgements=int((main["comparison_level"] == amplitude).sum()),
                ratio=mean,
                interval=interval,
            )
        )
    return TaskRatios(
        task=task,
        standard_level=standard,
        name=name,
        participants=len(table),
        answers=len(main),
        catch_trials=len(catch),
        catch_ratio=catch_mean(catch, "ratio"),
        surfaces=tuple(surfaces),
        power_law=power_law_of(table, confidence),
    )


class _Ratios(Statistic[tuple[TaskRatios, ...]]):
    key = "ratios"
    meaning = "judged ratios to a standard, and the exponent of their power function"
    methods = (
        "Judged ratios are geometric means across participants, with t-based intervals of their "
        "logarithms. The exponent is the mean of participants' regression slopes of log ratios on "
        "log {q.name} [[stevens1957]]."
    )
    headlines = (Named("*.power_law.exponent", "{0[0]}: exponent"),)

    def compute(self, inputs: Inputs) -> tuple[TaskRatios, ...] | NotComputed:
        return ratios(inputs.data.of(TRIALS), inputs.data.choices.confidence)


RATIOS = _Ratios()
