"""Check quartiles under all common definitions, because papers rarely name the definition.

Definitions differ in the position of the quartile among the sorted ratings x_1 to x_n. Four
definitions are checked. They may give a position between two ratings:

- linear at position (n - 1) / 4 + 1: R's default, NumPy, spreadsheets;
- linear at position (n + 1) / 4: SPSS, Minitab, Stata's default for other percentiles;
- median of the lower half, including the middle rating if n is odd: Tukey's hinges;
- median of the lower half, excluding the middle rating if n is odd: used in schools.

Published quartiles match if at least one definition gives both quartiles.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from slipscale.analysis.published.printed_numbers import Interval
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.table.published_table import Column


def lower_places(n: int) -> dict[str, Fraction]:
    """Return the position of the lower quartile, from 1 to n, under each definition.

    >>> {name: float(place) for name, place in lower_places(9).items()}
    {'linear': 3.0, 'weibull': 2.5, 'hinges': 3.0, 'halves': 2.5}
    """
    half, longer = n // 2, (n + 1) // 2
    return {
        "linear": Fraction(n - 1, 4) + 1,
        "weibull": min(max(Fraction(n + 1, 4), Fraction(1)), Fraction(n)),
        "hinges": Fraction(longer + 1, 2),
        "halves": Fraction(half + 1, 2),
    }


def are_met(column: Column, rows: Array) -> Array:
    """Return a mask of the rows of sorted ratings that have the published quartiles.

    Parameters
    ----------
    column : Column
        The published column.
    rows : ndarray of int, shape (m, n)
        Sorted data sets, in steps above the scale minimum.

    Returns
    -------
    ndarray of bool, shape (m,)
    """
    met = np.zeros(len(rows), dtype=bool)
    for place in lower_places(column.n).values():
        fits = np.ones(len(rows), dtype=bool)
        for at, allowed in _printed(column, place):
            below = int(at)
            share = at - below
            # The quartile is multiplied by the denominator of the fraction, to compute in whole
            # numbers.
            top, bottom = share.numerator, share.denominator
            values = (bottom - top) * rows[:, below - 1].astype(np.int64)
            if top:
                values += top * rows[:, below]
            inside = allowed.scaled(Fraction(bottom)).integers()
            fits &= (values >= inside.start) & (values < inside.stop)
        met |= fits
    return met


def _printed(column: Column, lower: Fraction) -> Iterator[tuple[Fraction, Interval]]:
    """Yield the position of each published quartile, and the interval of its values in steps."""
    scale = column.scale
    ends = ((column.lower_quartile, lower), (column.upper_quartile, column.n + 1 - lower))
    for printed, place in ends:
        if printed is not None:
            values = printed.values(column.rounding)
            yield place, values.scaled(1 / scale.step, -scale.minimum / scale.step)
