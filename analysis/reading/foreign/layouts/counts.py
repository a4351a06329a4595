"""Expand counts of answers to one row per answer.

A table contains two of the numbers of yes answers, of no answers and of all answers, or the
percentage of yes answers and the number of all answers.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from slipscale.analysis.reading.cells import places
from slipscale.analysis.reading.cleaning import numbers
from slipscale.analysis.reading.foreign.columns import ANSWER
from slipscale.analysis.reading.foreign.layouts.layout import Rows
from slipscale.faults import UserError

#: Columns that define counts.
COUNTS = ("yes_count", "no_count", "percent", "n")
#: Largest rounding error of a percentage.
ROUNDED = 0.5 + 1e-9


def one_row_per_answer(rows: Rows) -> pd.DataFrame:
    """Expand counts to one row per answer; return other tables unchanged.

    Raises
    ------
    UserError
        If a count is not a whole number from 0 to n, or a percentage does not belong to n answers.
    """
    frame, given = rows.frame, [name for name in COUNTS if name in rows.frame]
    if not given:
        return frame
    counts = {name: numbers(frame, name, rows.sources, rows.problems) for name in given}
    n = counts["n"] if "n" in counts else counts["yes_count"] + counts["no_count"]
    if "percent" in counts:
        yes = (counts["percent"] * n / 100).round()
        wrong = (counts["percent"] - 100 * yes / n).abs() > ROUNDED
        if counts["percent"].max() <= 1 and (counts["percent"] % 1 > 0).any():
            raise UserError(
                "{file}, column {column}: the largest percentage is {most:g}, so these are "
                "probably proportions from 0 to 1; expected percentages from 0 to 100 (multiply "
                "the column by 100)",
                file=rows.sources[0].name,
                column=rows.problems.title("percent"),
                most=counts["percent"].max(),
            )
    else:
        yes = counts["yes_count"] if "yes_count" in counts else n - counts["no_count"]
        wrong = pd.Series(False, frame.index)
    wrong |= ~((yes >= 0) & (yes <= n) & (yes % 1 == 0) & (n % 1 == 0))
    if wrong.any():
        at = int(wrong.to_numpy().argmax())
        cells = " and ".join(
            f"{rows.problems.title(name)} is {frame[name].iloc[at]}" for name in given
        )
        raise UserError(
            "{place}: {cells}; expected whole numbers, with 0 to n yes answers"
            + ("; a percentage (0 to 100) must belong to n answers" if "percent" in given else ""),
            place=places(frame.iloc[[at]], rows.sources)[0],
            cells=cells,
        )
    times = np.stack([yes, n - yes], axis=1).astype(int).ravel()
    rows_of_counts = np.repeat(np.arange(2 * len(frame)), times)
    every = frame.iloc[rows_of_counts // 2].reset_index(drop=True)
    return every.assign(**{ANSWER: 1 - rows_of_counts % 2})
