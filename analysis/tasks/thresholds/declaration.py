"""Declare thresholds from forced choice."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from slipscale.analysis.json_form import JsonObject
from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.reading.task_tables import by_task
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.psychometric_function import Answers
from slipscale.analysis.statistics.psychometrics.thresholds import threshold_values
from slipscale.analysis.statistics.statistic import SessionTable
from slipscale.analysis.tasks.declared.one_statistic import Figures, OneStatistic
from slipscale.analysis.tasks.thresholds import figures, section, sentences
from slipscale.analysis.tasks.thresholds.reading import TRIALS
from slipscale.analysis.tasks.thresholds.statistics import THRESHOLDS, TaskThresholds, curve_of
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.stimuli.quantity import Quantity


def _reversals(task: TaskThresholds, participant: str) -> JsonObject:
    """Return one participant's mean level at the reversals in each condition."""
    if isinstance(task.reversals, NotComputed):
        return {}
    return {
        _column(each.condition): own.mean_level
        for each in task.reversals.conditions
        for own in each.people
        if own.participant == participant
    }


def _column(condition: str) -> str:
    return "_".join(filter(None, ("reversals", condition.replace(" ", "_"), "level")))


def _thresholds(rows: pd.DataFrame, choices: AnalysisChoices) -> pd.DataFrame:
    """Return a table of log10 thresholds (participants by sessions), NaN if undetermined."""
    main = rows[~rows["catch"]]
    method = str(rows["method"].iloc[0])
    keys = [main[PARTICIPANT].astype(str), main["session"].astype(str)]
    answers = {
        key: Answers.of_trials(own["track_level"].tolist(), own["correct"].tolist())
        for key, own in main.groupby(keys)
    }
    values = threshold_values(
        list(answers.values()),
        method=method,
        curve=curve_of(method, choices),
        share=choices.threshold_share,
    )
    logs = np.log10(np.where(values > 0, values, np.nan))
    found: dict[str, dict[str, float]] = {}
    for (who, session), log in zip(answers, logs, strict=True):
        found.setdefault(str(session), {})[str(who)] = float(log)
    return pd.DataFrame(found)


class _Thresholds(OneStatistic[TaskThresholds]):
    name = "thresholds"
    trials = TRIALS
    statistics = (THRESHOLDS,)
    question = "What is the smallest {q.level}, or change in {q.level}, that can be felt?"
    what = "forced-choice"
    title = "Thresholds"

    task_name = staticmethod(sentences.title)
    task_answers = staticmethod(sentences.answers)
    task_remarks = staticmethod(sentences.remarks)
    task_doubts = staticmethod(sentences.doubts)
    task_blocks = staticmethod(section.blocks)

    def task_figures(
        self, task: TaskThresholds, trials: pd.DataFrame, quantity: Quantity
    ) -> Figures:
        own = trials[trials["task"] == task.task]
        drawn = {f"thresholds_{task.task}": figures.functions(task, own, quantity)}
        if own["track"].notna().any():
            drawn[f"tracks_{task.task}"] = figures.tracks(task, own, quantity)
        return drawn

    def task_rows(self, task: TaskThresholds) -> list[JsonObject]:
        """Return one row per participant, without values from fits that could not be computed."""
        found: list[JsonObject] = []
        for each in task.participants:
            row: JsonObject = {
                "task": task.task,
                "participant_id": each.participant,
                "standard_level": task.standard_level,
                "trials": each.trials,
                "correct": each.correct,
                "catch_trials": each.catch_trials,
                "catch_correct": each.catch_correct,
                **_reversals(task, each.participant),
            }
            if isinstance(each.function, NotComputed):
                found.append(row | {"reason": each.function.reason})
                continue
            low, high = each.function.threshold_level.interval
            row |= {
                "threshold_level": each.function.threshold_level.value,
                "threshold_ci_low": low,
                "threshold_ci_high": high,
                "slope": each.function.slope_value,
                "lapse": each.function.lapse,
            }
            if task.population:
                row["in_the_populations_fit_level"] = task.population.participants[each.participant]
            if each.weber_fraction:
                row["weber_fraction"] = each.weber_fraction.value
            if each.fit:
                row |= {"deviance": each.fit.deviance, "fit_p": each.fit.p}
            found.append(row)
        return found

    def session_tables(self, data: Dataset, _prepared: Prepared | None) -> Iterator[SessionTable]:
        """Yield one table of log10 thresholds (participants by sessions) per task."""
        for task, rows in by_task(data.of(TRIALS)):
            yield (
                f"{task}, threshold",
                f"log10 {data.quantity.unit_in_short}",
                _thresholds(rows, data.choices),
            )


ANALYSIS = _Thresholds()
