"""Tabulate scales."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from slipscale.analysis.tasks.scales.difference_scaling import DifferenceScale

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.analysis.json_form import JsonObject
    from slipscale.analysis.tasks.scales.statistics import TaskScale


def scale_table(tasks: Sequence[TaskScale]) -> pd.DataFrame:
    """Return one row per task, model and surface."""
    rows: list[JsonObject] = []
    for task in tasks:
        for name, chosen, compared in zip(task.surfaces, task.chosen, task.compared, strict=False):
            share = {"value": chosen / compared if compared else None}
            rows.append({"task": task.task, "model": "share chosen", "surface": name, **share})
        for found in (task.bradley_terry, task.thurstone, task.differences):
            if not found:
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
