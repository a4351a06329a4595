"""Ratio judgements as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.analysis.tasks.ratios.statistics import TaskRatios
from slipscale.analysis.writing.interval_columns import bounds


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
                **bounds(each.interval),
            }
            for task in tasks
            for each in task.surfaces
        ]
    )
