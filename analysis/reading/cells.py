"""Format table cells and long lists for messages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.reading.delimited import Source

#: Maximum number of characters quoted from a cell in a message.
LONGEST_CELL = 60
#: A column is rejected if it has more than `FEW` invalid cells and their share exceeds `FEW_SHARE`.
FEW, FEW_SHARE = 3, 0.05
#: Maximum number of participants to list in a message.
LISTED = 6


def places(rows: pd.DataFrame, sources: Sequence[Source]) -> list[str]:
    """Return "file, line n" for each row."""
    pairs = zip(rows["file"].tolist(), rows["line"].tolist(), strict=True)
    return [f"{sources[int(number)].name}, line {line}" for number, line in pairs]


def cell(value: object) -> str:
    r"""Format a cell for a message, on one line and shortened.

    >>> cell("five\nor six")
    'five or six'
    """
    text = " ".join(str(value).split())
    return text if len(text) <= LONGEST_CELL else f"{text[:LONGEST_CELL]} ..."


def listed(names: Iterable[str], most: int = LISTED) -> str:
    """Join names for a sentence, and shorten long lists.

    >>> listed("abcdefgh")
    'a, b, c, d, e, f and 2 more'
    """
    everyone = list(names)
    more = len(everyone) - most
    return ", ".join(everyone[:most]) + (f" and {more} more" if more > 0 else "")
