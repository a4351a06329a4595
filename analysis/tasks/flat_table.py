"""Results as a table: one column per key of ``inference.json``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from slipscale.analysis.json_form import record

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.analysis.json_form import JsonObject


def flat(rows: Sequence[object]) -> pd.DataFrame:
    """Return results as a table, under inference.json's keys.

    An interval ``[low, high]`` becomes two columns, such as ``ratio_ci_low ratio_ci_high``.
    """
    cells: list[JsonObject] = []
    for row in rows:
        cells.append({})
        for name, value in record(row).items():
            parts = zip(("_low", "_high"), value, strict=True) if isinstance(value, list) else ()
            cells[-1] |= {name + end: bound for end, bound in parts} or {name: value}
    return pd.DataFrame(cells)
