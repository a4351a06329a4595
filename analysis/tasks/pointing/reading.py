"""Read pointing trials: distance, width, movement time, and the selection along the movement."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.reading.task_tables import task_trials
from slipscale.experiments.protocols.pointing import ON_TARGET, PLAIN

if TYPE_CHECKING:
    from slipscale.analysis.reading.delimited import Problems

PLACES = ("start_x_mm", "start_y_mm", "target_x_mm", "target_y_mm")
SELECTED = ("selection_x_mm", "selection_y_mm")


def _along(frame: pd.DataFrame, _problems: Problems) -> pd.DataFrame:
    """Return trials with ``moved_mm``, the movement projected on the axis from start to target."""
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
