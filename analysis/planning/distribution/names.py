"""What numbers and conclusions of an analysis are called, for people.

A name that stands in no table is shown as it is: a new result needs no words to be seen.
"""

from __future__ import annotations

import re

from slipscale.analysis.tasks.table import STATISTICS

#: Conclusion's name -> what it says; in the order in which they are shown.
CONCLUSIONS = {
    rf"{each.key}\.{name}": words for each in STATISTICS for name, words in each.conclusions.items()
}
#: Number's name -> what it is, of those that are drawn and shown first.
HEADLINES = {
    rf"{each.key}\.{name}": words for each in STATISTICS for name, words in each.headlines.items()
}


def said(name: str, table: dict[str, str]) -> tuple[int, str]:
    """Return a name's place in a table and its words; behind all others and itself if unknown.

    >>> said("pairwise.0 - 0.5.p_holm", CONCLUSIONS)[1]
    '0 and 0.5 µm differ (paired t of logarithms, Holm)'
    """
    for place, (pattern, words) in enumerate(table.items()):
        if match := re.fullmatch(pattern, name):
            return place, words.format(*match.groups())
    return len(table), name
