"""Describe the numeric results and conclusions of an analysis in words.

Results without a description are listed under their internal name.
"""

from __future__ import annotations

import re

from slipscale.analysis.tasks.table import STATISTICS
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

#: Descriptions of conclusions in order of display, keyed by a pattern for the name.
CONCLUSIONS = {
    rf"{each.key}\.{name}": words for each in STATISTICS for name, words in each.conclusions.items()
}
#: Descriptions of the results that are plotted and listed first, keyed by a pattern for the name.
HEADLINES = {
    rf"{each.key}\.{name}": words for each in STATISTICS for name, words in each.headlines.items()
}


def said(name: str, table: dict[str, str], quantity: Quantity = PLATE_AMPLITUDE) -> tuple[int, str]:
    """Look up a result's name in a table of patterns; return its position and description.

    >>> said("pairwise.0 - 0.5.p_holm", CONCLUSIONS)[1]
    '0 and 0.5 µm differ (paired t test of logarithms, Holm)'
    """
    for place, (pattern, words) in enumerate(table.items()):
        if match := re.fullmatch(pattern, name):
            return place, words.format(*match.groups(), q=quantity)
    return len(table), name
