"""Cells of a table in messages: where they are, what they hold, how many may be wrong."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd

    from slipscale.analysis.reading.delimited import Source

#: Characters of a cell in a message.
LONGEST_CELL = 60
#: More wrong cells than both of these, the second as a share, and a column is misread.
FEW, FEW_SHARE = 3, 0.05


def places(rows: pd.DataFrame, sources: Sequence[Source]) -> list[str]:
    """Return "file, line n" for each row."""
    pairs = zip(rows["file"].tolist(), rows["line"].tolist(), strict=True)
    return [f"{sources[int(number)].name}, line {line}" for number, line in pairs]


def cell(value: object) -> str:
    r"""Return a cell for a message: on one line, and not too long.

    >>> cell("five\nor six")
    'five or six'
    """
    text = " ".join(str(value).split())
    return text if len(text) <= LONGEST_CELL else f"{text[:LONGEST_CELL]} ..."
