"""Convert results to a table with one column per key of ``inference.json``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from slipscale.analysis.json_form import record

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.analysis.json_form import JsonObject


def flat(rows: Sequence[object]) -> pd.DataFrame:
    """Return results as a table with the keys of inference.json; see `flat_under`."""
    return flat_under([({}, row) for row in rows])


def flat_under(rows: Sequence[tuple[JsonObject, object]]) -> pd.DataFrame:
    """Return results as a table, each row preceded by the cells of its parent.

    An interval ``[low, high]`` becomes two columns, such as ``ratio_ci_low ratio_ci_high``; a
    field called ``interval`` becomes ``ci_low ci_high``.
    """
    cells: list[JsonObject] = []
    for above, row in rows:
        cells.append(dict(above))
        for field, found in record(row).items():
            own = field == "interval"
            name, value = ("ci", found or [None, None]) if own else (field, found)
            parts = zip(("_low", "_high"), value, strict=True) if isinstance(value, list) else ()
            cells[-1] |= {name + end: bound for end, bound in parts} or {name: value}
    return pd.DataFrame(cells)
