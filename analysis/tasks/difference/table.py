"""Tabulate yes/no answers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from slipscale.experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.tasks.kind import Analysis

#: Columns of yes-no answers, included if they are not empty.
ANSWERS = (
    *(PARTICIPANT, "session", "run", "series", "trial", "step"),
    *("amplitude_before_um_pp", "amplitude_um_pp", "catch", "difference_felt"),
    *("confidence", "response_time", "verbal_report"),
)


def answers_table(analysis: Analysis) -> pd.DataFrame:
    """Return the analysed yes/no answers, on which all results for the task are based.

    For a quantity other than the plate's, includes the stimulus and its reference.
    """
    rows = analysis.dataset.differences
    kept = [name for name in ANSWERS if name in rows and not _empty(rows[name])]
    table = rows[kept].astype({"difference_felt": int})
    if not analysis.dataset.quantity.stepped:
        return table.rename(
            columns={
                "amplitude_before_um_pp": "amplitude_um_pp",
                "amplitude_um_pp": "reference",
                "difference_felt": "yes",
            }
        )
    return table


def _empty(cells: pd.Series[Any]) -> bool:
    return bool(cells.isna().all() or (cells.astype(str) == "").all())
