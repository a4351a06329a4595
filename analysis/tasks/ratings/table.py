"""Ratings on a line as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.analysis.tasks.ratings.statistics import TaskRatings
from slipscale.analysis.writing.interval_columns import bounds


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
                **bounds(each.interval),
                "at_left_end": each.at_left,
                "at_right_end": each.at_right,
            }
            for task in tasks
            for each in task.surfaces
        ]
    )
