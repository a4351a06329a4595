"""Magnitude production as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.analysis.tasks.productions.statistics import TaskProductions
from slipscale.analysis.writing.interval_columns import bounds


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
                **bounds(each.interval),
            }
            for task in tasks
            for each in task.numbers
        ]
    )
