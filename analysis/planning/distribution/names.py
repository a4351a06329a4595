"""Describe the numeric results and conclusions of an analysis in words.

Results without a description are listed under their internal name.
"""

from __future__ import annotations

from collections.abc import Mapping

from slipscale.analysis.planning.distribution.numbers import ResultName
from slipscale.analysis.tasks.table import STATISTICS
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

#: Descriptions in order of display, keyed by path.
Words = Mapping[tuple[str, ...], str]
#: Descriptions of conclusions.
CONCLUSIONS: Words = {
    (each.key, *named.path.split(".")): named.words
    for each in STATISTICS
    for named in each.conclusions
}
#: Descriptions of the results that are plotted and listed first.
HEADLINES: Words = {
    (each.key, *named.path.split(".")): named.words
    for each in STATISTICS
    for named in each.headlines
}


def said(name: ResultName, table: Words, quantity: Quantity = PLATE_AMPLITUDE) -> tuple[int, str]:
    """Look up a result in a table of descriptions; return its position and description.

    >>> from slipscale.analysis.planning.distribution.numbers import Label
    >>> name = ResultName(("pairwise", Label(("0", "0.5")), "p_holm"))
    >>> said(name, CONCLUSIONS)[1]
    '0 and 0.5 µm differ (paired t test of logarithms, Holm)'
    """
    for place, (path, words) in enumerate(table.items()):
        if (found := name.at(path)) is not None:
            return place, words.format(*found, q=quantity)
    return len(table), str(name)
