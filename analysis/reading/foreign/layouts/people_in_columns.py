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
    # The number of all answers is no participant, whether it is a column or stated.
    names = [name for name in frame.columns if name not in ("file", "line", PARTICIPANT, "n")]
    first, people = names[:1], names[1:]
    if not people or not len(frame):
        raise UserError(
            "{file}: no answers; expected the levels in the first column, and one column per "
            "participant",
            file=rows.sources[0].name,
        )
    levels = as_numbers(frame[first[0]])[1]
    # Lines above the first level belong to the header.
    above = (levels.notna().cumsum() == 0) & frame[first[0]].notna()
    parts = []
    for who in people:
        own = frame.loc[~above, ["file", "line"]].copy()
        own[PARTICIPANT], own[STIMULUS] = who, frame.loc[~above, first[0]]
        cells = frame.loc[~above, who]
        number = OF.search(" ".join(frame.loc[above, who].astype("str").dropna()))
        of = frame.loc[~above, "n"] if "n" in frame else number and number[1]
        parts.append(
            own.assign(estimate=cells) if of is None else own.assign(n=of, yes_count=cells)
        )
    counted = ["yes_count" in part for part in parts]
    if any(counted) != all(counted):
        raise UserError(
            "{file}: only some columns state a number of answers, such as 'of 20'; state it for "
            "all with --n NUMBER",
            file=rows.sources[0].name,
        )
    return joined(parts, "yes_count" if all(counted) else RESPONSE)
