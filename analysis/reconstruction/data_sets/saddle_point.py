"""Approximate the number of data sets consistent with a column by the saddle-point method.

The number of multisets with n values, sum S and sum of squares Q is the coefficient of z^n x^S y^Q
in a generating function: the product over all values v of 1 / (1 - z x^v y^(v²)). The logarithm of
the generating function is convex in the logarithms of z, x and y. Laplace's method at the saddle
point of the function approximates the coefficient (Good, 1957; Daniels, 1954). The approximation is
doubled, because S and Q have the same parity, so only half of all pairs (S, Q) can occur.
"""

from __future__ import annotations

from itertools import chain, combinations
from math import exp, log, pi
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.partition import Moments, Wanted
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.data_sets.constraints import Targets

# Maximum number of sums for which the estimate is computed. Their mean estimate is used for all
# sums.
SUMS_LOOKED_AT = 15
STEPS = 200
# Estimates require that more than this proportion of multisets contain the required values.
LEAST_SHARE = 0.02
CONVERGED = 1e-10
# Maximum number of scale values. More would need gigabytes.
MOST_VALUES = 1_000_000


def log10_multisets(targets: Targets) -> float | None:
    """Estimate the decimal logarithm of the number of multisets, or return None.

    Returns None if the method does not converge, if a median is published, if few multisets contain
    a published extreme value, if a published percentage leaves several possible frequencies of a
    rating, or if the scale has too many values.
    """
    by_sum: dict[int, list[Wanted]] = {}
    for wish in targets.wanted or targets.looked_at:
        if wish.medians is not None or wish.high - wish.low > MOST_VALUES:
            return None
        by_sum.setdefault(wish.moments.total, []).append(wish)
    if not by_sum:
        return None
    sums = sorted(by_sum)
    chosen = {sums[round(i)] for i in np.linspace(0, len(sums) - 1, SUMS_LOOKED_AT)}
    logs = []
    for total in chosen:
        wishes = by_sum[total]
        found = _log_with_extremes(wishes[len(wishes) // 2])
        if found is None:
            return None
        logs.append(found + log(len(wishes)))
    mean = np.logaddexp.reduce(logs) - log(len(logs))
    # If only a sample of the pairs is listed, the estimate is scaled up to all pairs.
    more = targets.pairs / len(targets.looked_at) if targets.looked_at else 1.0
    return float((mean + log(len(sums)) + log(more)) / log(10))


def _log_with_extremes(wish: Wanted) -> float | None:
    """Return the logarithm of the number of multisets that contain the required values.

    The principle of inclusion and exclusion subtracts multisets without a required value from all
    multisets within the bounds.
    """
    required = _told(wish)
    if required is None:
        return None
    moments, holes, present = required
    every = chain.from_iterable(combinations(present, size) for size in range(len(present) + 1))
    reference: float | None = None
    share = 0.0
    for lacking in every:
        without = holes.union(*lacking)
        values = [v for v in range(wish.low, wish.high + 1) if v not in without]
        found = _log_coefficient(moments, values)
        if found is None:
            return None
        reference = found if reference is None else reference
        share += (-1) ** len(lacking) * exp(found - reference)
    return reference + log(share) if reference is not None and share > LEAST_SHARE else None


def _told(wish: Wanted) -> tuple[Moments, frozenset[int], list[frozenset[int]]] | None:
    """Return the moments of the free values, the fixed values, and sets of required values.

    The frequencies of fixed values are known. At least one value from each set must be present.
    Returns None if a published percentage leaves several possible frequencies of a rating.
    """
    moments, holes, occurring = wish.moments, set(), set()
    forced = []
    for value, least, most in wish.occurrences:
        if least == most:
            moments = moments.without(value, least)
            holes.add(value)
            occurring |= {value} if least else set()
        elif (least, most) == (1, wish.moments.n):
            forced.append(frozenset({value}))
        else:
            return None
    if moments.n < 2 or moments.squares < 0:  # noqa: PLR2004 - nothing left to approximate
        return None
    present = [frozenset(kept - holes) for kept in wish.present if not kept & occurring]
    return moments, frozenset(holes), [*present, *forced]


def _log_coefficient(moments: Moments, of: list[int]) -> float | None:
    """Return the logarithm of the number of multisets of the values `of` with the given moments."""
    n, total, squares = moments.n, moments.total, moments.squares
    mean = total / n
    scale = max((squares / n - mean**2), 1e-12) ** 0.5
    if len(of) < 3:  # noqa: PLR2004 - n, sum and sum of squares leave nothing open
        return None
    u = (np.array(of) - mean) / scale
    powers = np.stack([np.ones_like(u), u, u**2])
    wanted = np.array([n, 0.0, float(n)])  # in terms of u, which has mean 0 and variance 1
    at = np.array([-3.0, 0.0, -0.5])
    value = _objective(at, powers, wanted)
    for _ in range(STEPS):
        occupied = 1 / np.expm1(-(at @ powers))
        gradient = powers @ occupied - wanted
        hessian = (powers * (occupied * (1 + occupied))) @ powers.T
        step = np.linalg.solve(hessian, -gradient)
        decrease = float(-gradient @ step)
        if decrease < CONVERGED:
            _, log_determinant = np.linalg.slogdet(2 * pi * hessian)
            # The factor 2 accounts for the equal parity of S and Q. Changing from u to S and Q
            # divides by scale and scale².
            return float(log(2) + value - log_determinant / 2 - 3 * log(scale))
        size = 1.0
        while (new := _objective(at + size * step, powers, wanted)) > value - size * decrease / 4:
            size /= 2
            if size < CONVERGED:
                return None
        at, value = at + size * step, new
    return None


def _objective(at: Array, powers: Array, moments: Array) -> float:
    """Return the function to minimise, or infinity if the generating function diverges."""
    exponents = at @ powers
    if exponents.max() >= 0:
        return float("inf")
    return float(-np.log(-np.expm1(exponents)).sum() - at @ moments)


def words(log10_count: float) -> str:
    """Format an approximate count, given its decimal logarithm.

    >>> words(40.398)
    'about 2.5e+40'
    """
    power = int(log10_count // 1)
    return f"about {10 ** (log10_count - power):.1f}e+{power}"
