"""Reshape a table with levels in the first column and one participant per further column.

Cells are estimates. They are numbers of yes answers if the number of all answers is stated with
``--n``, or in a second header line such as "correct of 20".
"""

from __future__ import annotations

import re

import pandas as pd

from slipscale.analysis.reading.cleaning import as_numbers
from slipscale.analysis.reading.foreign.columns import RESPONSE, STIMULUS
from slipscale.analysis.reading.foreign.layouts.layout import Rows
from slipscale.analysis.reading.foreign.layouts.wide import joined
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError

#: Number of all answers in a header: "n correct of 20", "right/20".
OF = re.compile(r"(?:\bof|/)\s*(\d+)\b")


def reshape(rows: Rows) -> pd.DataFrame:
    """Return one row per level and participant."""
    frame = rows.frame
    first, *people = [name for name in frame.columns if name not in ("file", "line", PARTICIPANT)]
    if not people:
        raise UserError(
            "{file}: one column; expected the levels in the first column, and one column per "
            "participant",
            file=rows.sources[0].name,
        )
    levels = as_numbers(frame[first])[1]
    # Lines above the first level belong to the header.
    above = (levels.notna().cumsum() == 0) & frame[first].notna()
    n = rows.mapping.columns.n
    parts = []
    for who in people:
        own = frame.loc[~above, ["file", "line"]].copy()
        own[PARTICIPANT], own[STIMULUS] = who, frame.loc[~above, first]
        cells = frame.loc[~above, who]
        number = OF.search(" ".join(frame.loc[above, who].astype(str)))
        counted = n or (number and number[1])
        parts.append(
            own.assign(n=counted, yes_count=cells) if counted else own.assign(estimate=cells)
        )
    counted = ["yes_count" in part for part in parts]
    if any(counted) != all(counted):
        raise UserError(
            "{file}: only some columns state a number of answers, such as 'of 20'; state it for "
            "all with --n NUMBER",
            file=rows.sources[0].name,
        )
    return joined(parts, "yes_count" if all(counted) else RESPONSE)
