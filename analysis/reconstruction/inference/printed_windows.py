"""Compute the intervals of |t|, F or r that match all numbers published for a test.

The published statistic, p and effect size are each converted to an interval of the statistic, and
these intervals are intersected. With fixed degrees of freedom, p decreases as |t| or F increases,
whereas Cohen's d and partial η² increase. The degrees of freedom of Welch's t depend on the data,
so the published p of a Welch test is not converted to an interval of t, but checked in
`group_statistics.prints`.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, sqrt
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from slipscale.analysis.published.printed_numbers import Printed
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.table.printed_tests import PrintedTest

# Floating-point tolerance for comparisons with a published number.
SLACK = 1e-9
Window = tuple[float, float]


def between(printed: Printed | None, rule: str) -> Window:
    """Return the interval of values that round to `printed`, or all values if it is None."""
    if printed is None:
        return -inf, inf
    values = printed.values(rule)
    return float(values.low), float(values.high)


def size_of(printed: Printed | None, rule: str) -> Window:
    """Return the interval of absolute values that round to a published number."""
    low, high = between(printed and type(printed)(printed.text.lstrip("+-")), rule)
    return max(low, 0.0), high


def p_between(test: PrintedTest) -> Window:
    """Return the interval of p-values that match the published `p` and `p_below`."""
    low, high = between(test.p, test.rounding)
    if test.p_below is not None:
        high = min(high, float(test.p_below.value))
    return max(low, 0.0), min(high, 1.0)


def t_window(test: PrintedTest, degrees: float, t_of_d: float) -> Window:
    """Return the interval of |t| that matches a published t test.

    Parameters
    ----------
    test : PrintedTest
        A paired or independent t test.
    degrees : float
        Degrees of freedom of the test.
    t_of_d : float
        Value of t that corresponds to a Cohen's d of 1: √n for pairs, √(n₁ n₂ / (n₁ + n₂)) for
        groups.
    """
    from scipy.stats import t as student

    least_p, most_p = (p / test.sides for p in p_between(test))
    d_low, d_high = size_of(test.d, test.rounding)
    low, high = size_of(test.statistic, test.rounding)
    return (
        max(low, d_low * t_of_d, float(student.isf(min(most_p, 0.5), degrees))),
        min(high, d_high * t_of_d, float(student.isf(least_p, degrees)) if least_p > 0 else inf),
    )


def f_window(test: PrintedTest, degrees: tuple[int, int]) -> Window:
    """Return the interval of F that matches a published F test."""
    from scipy.stats import f as fisher

    least_p, most_p = p_between(test)
    low, high = size_of(test.statistic, test.rounding)
    share_low, share_high = size_of(test.partial_eta_squared, test.rounding)
    ratio = degrees[1] / degrees[0]
    f_of_share = [
        inf if share >= 1 else ratio * share / (1 - share) for share in (share_low, share_high)
    ]
    return (
        max(low, f_of_share[0], float(fisher.isf(most_p, *degrees))),
        min(high, f_of_share[1], float(fisher.isf(least_p, *degrees)) if least_p > 0 else inf),
    )


def r_windows(test: PrintedTest, n: int) -> list[Window]:
    """Return the intervals of r that match a published test, including the sign of r."""
    from scipy.stats import t as student

    degrees = n - 2
    if not degrees:
        # For n = 2, r is 1 or -1 and has no p.
        return [] if test.p or test.p_below else [between(test.statistic, test.rounding)]
    least_p, most_p = (p / test.sides for p in p_between(test))
    t_near = float(student.isf(min(most_p, 0.5), degrees))
    near = t_near / sqrt(t_near**2 + degrees)
    far = 1.0
    if least_p > 0:
        t_far = float(student.isf(least_p, degrees))
        far = t_far / sqrt(t_far**2 + degrees)
    low, high = between(test.statistic, test.rounding)
    both = ((max(low, -far), min(high, -near)), (max(low, near), min(high, far)))
    return [window for window in dict.fromkeys(both) if window[0] <= window[1]]


def windows(test: PrintedTest, n: Sequence[int]) -> list[Window]:
    """Return the intervals of |t|, F or r that match a published test, given each column's n.

    The list of intervals is empty if no value matches. For Welch's t, whose degrees of freedom
    depend on the data, only the published t is used.
    """
    k, first = len(n), int(n[0])
    if test.kind == "correlation":
        return r_windows(test, first)
    if test.kind == "paired_t":
        found = t_window(test, first - 1, sqrt(first))
    elif test.kind == "independent_t":
        found = t_window(test, sum(n) - 2, 1 / sqrt(sum(1 / m for m in n)))
    elif test.kind == "welch_t":
        found = size_of(test.statistic, test.rounding)
    else:
        error = (k - 1) * (first - 1) if test.kind == "rm_f" else sum(n) - k
        found = f_window(test, (k - 1, error))
    return [found] if found[0] <= found[1] else []


def fits(values: Array, window: Window) -> Array:
    """Return a mask of the values that lie in an interval, allowing for floating-point error."""
    slack = SLACK * (1 + np.abs(values))
    found: Array = (values >= window[0] - slack) & (values <= window[1] + slack)
    return found
