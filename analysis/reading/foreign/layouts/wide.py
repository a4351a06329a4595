"""Reshape a wide table, which has one row per participant and one column per level.

Cells are estimates or, with ``--n``, numbers of yes answers.
"""

from __future__ import annotations

import pandas as pd

from slipscale.analysis.reading.foreign.columns import RESPONSE, STIMULUS
from slipscale.analysis.reading.foreign.layouts.layout import Rows


def reshape(rows: Rows) -> pd.DataFrame:
    """Return one row per level."""
    levels, frame = rows.mapping.levels, rows.frame
    content = "yes_count" if rows.mapping.columns.n else RESPONSE
    kept = [name for name in frame.columns if name not in levels]
    parts = []
    for column, level in levels.items():
        part = frame[kept].copy()
        part[STIMULUS], part[content] = level, frame[column]
        parts.append(part)
    return joined(parts, content)


def joined(parts: list[pd.DataFrame], content: str) -> pd.DataFrame:
    """Join tables of one level or participant each, in the order of the file's lines."""
    # If one column is text, all are read as text, so that cells are parsed in the same way.
    if any(not pd.api.types.is_numeric_dtype(part[content]) for part in parts):
        parts = [part.astype({content: "str"}) for part in parts]
    return pd.concat(parts, ignore_index=True).sort_values(
        ["file", "line"], kind="stable", ignore_index=True
    )
