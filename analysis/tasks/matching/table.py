"""Tabulate matching."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.analysis.json_form import JsonObject
    from slipscale.analysis.tasks.matching.statistics import MatchedReference


def matching_table(found: Sequence[MatchedReference]) -> pd.DataFrame:
    """Return one row per reference."""
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
            if tested:
                low, high = tested.interval
                row |= {
                    f"{name}_um_pp": tested.mean,
                    f"{name}_ci_low": low,
                    f"{name}_ci_high": high,
                    f"{name}_p": tested.p,
                }
        rows.append(row)
    return pd.DataFrame(rows)
