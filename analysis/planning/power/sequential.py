"""Set the significance level of each interim analysis so that the overall level is maintained.

The method is alpha spending (Lan and DeMets, 1983, Biometrika 70, 659-663), with the spending
functions for O'Brien-Fleming and Pocock boundaries. The significance levels are computed by
recursive integration (Armitage, McPherson and Rowe, 1969, Journal of the Royal Statistical Society
A 132, 235-244), with Gauss quadrature between the boundaries.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Literal

import numpy as np

from slipscale.faults import UserError

Spending = Literal["obrien-fleming", "pocock"]
NODES = 200
FARTHEST_Z = 9.0


def _obrien_fleming(share: float, alpha: float) -> float:
    from scipy.special import ndtr, ndtri

    return float(2 * (1 - ndtr(ndtri(1 - alpha / 2) / math.sqrt(share))))


def _pocock(share: float, alpha: float) -> float:
    return alpha * math.log1p((math.e - 1) * share)


SPENDING: dict[Spending, Callable[[float, float], float]] = {
    "obrien-fleming": _obrien_fleming,
    "pocock": _pocock,
}


def look_sizes(participants: int, looks: int, fewest: int = 3) -> tuple[int, ...]:
    """Return the number of participants at each interim analysis, evenly spaced.

    The last analysis includes all participants.

    >>> look_sizes(32, 3)
    (11, 21, 32)
    """
    sizes = tuple(round(participants * look / looks) for look in range(1, looks + 1))
    if looks < 1 or sizes[0] < fewest:
        raise UserError(
            "--looks {looks}: the first interim analysis would take place after {first_size} of"
            " {participants} participants; expected {fewest} participants or more",
            looks=looks,
            first_size=sizes[0] if sizes else 0,
            participants=participants,
            fewest=fewest,
        )
    return sizes


@lru_cache(maxsize=256)
def levels(sizes: tuple[int, ...], alpha: float, spending: Spending) -> tuple[float, ...]:
    """Return the two-sided significance level of each interim analysis.

    Parameters
    ----------
    sizes : tuple of int
        Number of participants at each analysis, in ascending order. The last number is the total.
    alpha : float
        Overall significance level of the study.
    spending : {"obrien-fleming", "pocock"}
    """
    from scipy.optimize import brentq
    from scipy.special import ndtr

    # Half of alpha on each side, as in published tables of two-sided boundaries.
    spent = [2 * SPENDING[spending](size / sizes[-1], alpha / 2) for size in sizes]
    found: list[float] = []
    # Density of the test statistic at the quadrature nodes, if the study continues.
    nodes, density, before = np.zeros(1), np.ones(1), 0.0
    for size, until in zip(sizes, spent, strict=True):
        information = size / sizes[-1]
        step = math.sqrt(information - before)

        def beyond(z: float) -> float:
            edge = z * math.sqrt(information)  # noqa: B023 - called in this turn alone
            tails = ndtr((nodes - edge) / step) + ndtr((-nodes - edge) / step)  # noqa: B023
            return float(density @ tails)  # noqa: B023

        share = until - ((found and spent[len(found) - 1]) or 0.0)
        z = brentq(lambda z, beyond=beyond, share=share: beyond(z) - share, 0.0, FARTHEST_Z)
        found.append(float(2 * (1 - ndtr(z))))
        edge = z * math.sqrt(information)
        at, weight = np.polynomial.legendre.leggauss(NODES)
        after = at * edge
        kernel = np.exp(-0.5 * ((after[:, None] - nodes) / step) ** 2) / (
            step * math.sqrt(2 * math.pi)
        )
        nodes, density, before = after, weight * edge * (kernel @ density), information
    return tuple(found)
