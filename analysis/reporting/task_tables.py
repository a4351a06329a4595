"""Results of thresholds, scales and matching as tables: what their CSV files hold."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.scaling.difference_scaling import DifferenceScale

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.analysis.reporting.json_form import JsonObject
    from slipscale.analysis.result import Analysis
    from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
    from slipscale.analysis.statistics.matching import MatchedReference
    from slipscale.analysis.statistics.productions import TaskProductions
    from slipscale.analysis.statistics.psychometrics.forced_choice import TaskThresholds
    from slipscale.analysis.statistics.ratings import TaskRatings
    from slipscale.analysis.statistics.ratio_judgements import TaskRatios
    from slipscale.analysis.statistics.scaling.task_scales import TaskScale


def task_tables(analysis: Analysis) -> dict[str, pd.DataFrame]:
    """Return the tables of the tasks that were run, by name."""
    found: dict[str, pd.DataFrame] = {}
    inference = analysis.inference
    if not isinstance(inference.thresholds, NotComputed):
        found["thresholds"] = threshold_table(inference.thresholds)
    if not isinstance(inference.scales, NotComputed):
        found["scales"] = scale_table(inference.scales)
    if not isinstance(inference.matching, NotComputed):
        found["matching"] = matching_table(inference.matching)
    if not isinstance(inference.ratings, NotComputed):
        found["ratings"] = rating_table(inference.ratings)
    if not isinstance(inference.ratios, NotComputed):
        found["ratios"] = ratio_table(inference.ratios)
    if not isinstance(inference.productions, NotComputed):
        found["productions"] = production_table(inference.productions)
    return found


def _bounds(interval: ConfidenceInterval | None) -> JsonObject:
    """Return an interval's two columns."""
    low, high = (None, None) if interval is None else interval
    return {"ci_low": low, "ci_high": high}


def rating_table(tasks: Sequence[TaskRatings]) -> pd.DataFrame:
    """Return one row a task and surface."""
    return pd.DataFrame(
        [
            {
                "task": task.task,
                "surface": each.surface,
                "participants": each.participants,
                "ratings": each.ratings,
                "mean": each.mean,
                "standard_deviation": each.sd,
                **_bounds(each.interval),
                "at_left_end": each.at_left,
                "at_right_end": each.at_right,
            }
            for task in tasks
            for each in task.surfaces
        ]
    )


def ratio_table(tasks: Sequence[TaskRatios]) -> pd.DataFrame:
    """Return one row a task, standard and surface."""
    return pd.DataFrame(
        [
            {
                "task": task.task,
                "standard_um_pp": task.standard_um_pp,
                "comparison_um_pp": each.comparison_um_pp,
                "participants": each.participants,
                "judgements": each.judgements,
                "ratio": each.ratio,
                **_bounds(each.interval),
            }
            for task in tasks
            for each in task.surfaces
        ]
    )


def production_table(tasks: Sequence[TaskProductions]) -> pd.DataFrame:
    """Return one row a task and number."""
    return pd.DataFrame(
        [
            {
                "task": task.task,
                "standard_um_pp": task.standard_um_pp,
                "modulus": task.modulus,
                "number": each.number,
                "participants": each.participants,
                "productions": each.productions,
                "amplitude_um_pp": each.amplitude_um_pp,
                **_bounds(each.interval),
            }
            for task in tasks
            for each in task.numbers
        ]
    )


def scale_table(tasks: Sequence[TaskScale]) -> pd.DataFrame:
    """Return one row a task, model and surface."""
    rows: list[JsonObject] = []
    for task in tasks:
        for name, chosen, compared in zip(task.surfaces, task.chosen, task.compared, strict=False):
            share = {"value": chosen / compared if compared else None}
            rows.append({"task": task.task, "model": "share chosen", "surface": name, **share})
        for found in (task.bradley_terry, task.thurstone, task.differences):
            if isinstance(found, NotComputed):
                continue
            model = "differences" if isinstance(found, DifferenceScale) else found.model
            for name, value, interval in zip(
                task.surfaces, found.values, found.intervals, strict=True
            ):
                low, high = (None, None) if interval is None else interval
                rows.append(
                    {
                        "task": task.task,
                        "model": model,
                        "surface": name,
                        "value": value,
                        "ci_low": low,
                        "ci_high": high,
                    }
                )
    return pd.DataFrame(rows)


def matching_table(found: Sequence[MatchedReference]) -> pd.DataFrame:
    """Return one row a reference."""
    rows: list[JsonObject] = []
    for each in found:
        row: JsonObject = {
            "task": each.task,
            "reference_um_pp": each.reference_um_pp,
            "matches": each.matches,
            "participants": each.participants,
            "mean_um_pp": each.mean_um_pp,
            "variability_um_pp": each.variability_um_pp,
            "ascending_um_pp": each.ascending_um_pp,
            "descending_um_pp": each.descending_um_pp,
            "felt_again": each.felt_again,
            "catch_trials": each.catch_trials,
            "catch_error_um_pp": each.catch_error_um_pp,
        }
        for name, tested in (("bias", each.bias_um_pp), ("direction", each.direction_um_pp)):
            if not isinstance(tested, NotComputed):
                low, high = tested.interval
                row |= {
                    f"{name}_um_pp": tested.mean,
                    f"{name}_ci_low": low,
                    f"{name}_ci_high": high,
                    f"{name}_p": tested.p,
                }
        rows.append(row)
    return pd.DataFrame(rows)


def threshold_table(tasks: Sequence[TaskThresholds]) -> pd.DataFrame:
    """Return one row a participant and task; missing numbers where nothing was fitted."""
    rows: list[JsonObject] = []
    for task in tasks:
        for each in task.participants:
            row: JsonObject = {
                "task": task.task,
                "participant_id": each.participant,
                "standard_um_pp": task.standard_um_pp,
                "trials": each.trials,
                "correct": each.correct,
                "catch_trials": each.catch_trials,
                "catch_correct": each.catch_correct,
            }
            if isinstance(each.function, NotComputed):
                rows.append(row | {"reason": each.function.reason})
                continue
            low, high = each.function.threshold_um_pp.interval
            row |= {
                "threshold_um_pp": each.function.threshold_um_pp.value,
                "threshold_ci_low": low,
                "threshold_ci_high": high,
                "slope": each.function.slope_value,
                "lapse": each.function.lapse,
            }
            for name, other in (
                ("maximum_likelihood", each.maximum_likelihood),
                ("psignifit", each.psignifit),
            ):
                if not isinstance(other, NotComputed):
                    low, high = other.threshold_um_pp.interval
                    row |= {
                        f"{name}_threshold_um_pp": other.threshold_um_pp.value,
                        f"{name}_threshold_ci_low": low,
                        f"{name}_threshold_ci_high": high,
                        f"{name}_slope": other.slope_value,
                        f"{name}_lapse": other.lapse,
                    }
            if not isinstance(each.weber_fraction, NotComputed):
                row["weber_fraction"] = each.weber_fraction.value
            if not isinstance(each.fit, NotComputed):
                row |= {"deviance": each.fit.deviance, "fit_p": each.fit.p}
            rows.append(row)
    return pd.DataFrame(rows)
