"""Tabulate thresholds."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed

if TYPE_CHECKING:
    from slipscale.analysis.json_form import JsonObject
    from slipscale.analysis.tasks.thresholds.statistics import TaskThresholds


def rows(task: TaskThresholds) -> list[JsonObject]:
    """Return one row per participant; missing numbers if nothing was fitted."""
    found: list[JsonObject] = []
    for each in task.participants:
        row: JsonObject = {
            "task": task.task,
            "participant_id": each.participant,
            "standard_um_pp": task.standard_um_pp,
            "trials": each.trials,
            "correct": each.correct,
            "catch_trials": each.catch_trials,
            "catch_correct": each.catch_correct,
            **_reversals(task, each.participant),
        }
        if isinstance(each.function, NotComputed):
            found.append(row | {"reason": each.function.reason})
            continue
        low, high = each.function.threshold_um_pp.interval
        row |= {
            "threshold_um_pp": each.function.threshold_um_pp.value,
            "threshold_ci_low": low,
            "threshold_ci_high": high,
            "slope": each.function.slope_value,
            "lapse": each.function.lapse,
        }
        if task.population:
            row["in_the_populations_fit_um_pp"] = task.population.participants[each.participant]
        if each.weber_fraction:
            row["weber_fraction"] = each.weber_fraction.value
        if each.fit:
            row |= {"deviance": each.fit.deviance, "fit_p": each.fit.p}
        found.append(row)
    return found


def _reversals(task: TaskThresholds, participant: str) -> JsonObject:
    """Return one participant's means of reversals, one cell per condition."""
    if isinstance(task.reversals, NotComputed):
        return {}
    return {
        _column(each.condition): own.mean_um_pp
        for each in task.reversals.conditions
        for own in each.people
        if own.participant == participant
    }


def _column(condition: str) -> str:
    return "_".join(filter(None, ("reversals", condition.replace(" ", "_"), "um_pp")))
