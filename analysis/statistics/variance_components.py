"""Estimate variance components from unbalanced repeated estimates by REML.

The model is: log estimate = mean of the level + participant + participant x level + repetition.
Restricted maximum likelihood needs only the mean and number of estimates per participant and level,
and the sum of squares around these means (Searle, Casella and McCulloch 1992, Variance Components,
ch. 6). If all participants have the same number of repetitions at every level and no component is
negative, the result equals the mean-squares estimate.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.statistics.arrays import Array

#: Starting values of the search: the participant and interaction components, each relative to the
#: repetition variance.
STARTS = ((1.0, 0.5), (0.05, 0.05))
#: Most steps of the search, and the step, relative to the ratios, at which it ends.
STEPS, CLOSE = 500, 1e-9
#: Relative rise of the deviance that rounding can explain.
ROUNDING = 1e-13


def reml_components(
    means: Array, counts: Array, squares: Array, starts: Sequence[Sequence[float]] = STARTS
) -> Array:
    """Return the variances of participant, participant x level and repetition, each at least 0.

    Parameters
    ----------
    means : array, shape (participants, levels)
        Mean estimate per participant and level. Entries without estimates are ignored.
    counts : array, shape (participants, levels)
        Number of estimates per participant and level, which may be 0.
    squares : array, shape (participants,)
        Sum of squared deviations of each participant's estimates from their means per level.
    starts : sequence of (float, float)
        Starting values of the two variance ratios (see `STARTS`).
    """
    used = (counts > 0).any(axis=0)
    own, cells = np.where(counts > 0, means, 0.0)[:, used], counts[:, used]
    within, freedom = squares.sum(), counts.sum() - (counts > 0).sum()
    # Participants with the same counts form a group, summarised by its size, sums and products.
    order = np.lexsort(cells.T)
    own, cells = own[order], cells[order]
    first = np.flatnonzero(np.append(True, (np.diff(cells, axis=0) != 0).any(axis=1)))
    counts, people = cells[first], np.diff(first, append=len(cells))
    sums = np.add.reduceat(own, first)
    products = np.add.reduceat(own[:, :, None] * own[:, None, :], first)
    fit = partial(_fit, alike=(counts, people, sums, products), within=within, freedom=freedom)
    found, point = min((_lowest(fit, np.array(start)) for start in starts), key=_deviance_of)
    return np.array([*point, 1.0]) * found.scale


class _Fit(NamedTuple):
    """What the restricted likelihood is at two variance ratios."""

    #: -2 log restricted likelihood, without its constant.
    deviance: float
    #: Gradient of the deviance, and its expected second derivatives without the levels' share.
    gradient: Array
    curvature: Array
    #: Repetition variance, which follows from the ratios by a closed formula.
    scale: float


def _deviance_of(found: tuple[_Fit, Array]) -> float:
    return found[0].deviance


def _lowest(fit: Callable[[Array], _Fit], point: Array) -> tuple[_Fit, Array]:
    """Return the fit of lowest deviance and its ratios, each at least 0, by Fisher scoring.

    A step that does not lower the deviance is halved. A ratio that is 0 and would fall stays there.
    """
    here = fit(point)
    for _ in range(STEPS):
        free = (point > 0) | (here.gradient < 0)
        step = np.zeros(2)
        curvature = here.curvature[np.ix_(free, free)]
        # With one level, both ratios have the same effect, so the curvature has no inverse.
        step[free] = -np.linalg.lstsq(curvature, here.gradient[free])[0]
        if (point + step < 0).any():
            # A step cut off at 0 can rise in the other ratio, unless each follows its own slope.
            step[free] = -here.gradient[free] / np.diag(curvature)
        while True:
            there = np.maximum(point + step, 0.0)
            if np.abs(there - point).max() <= CLOSE * (1 + point.max()):
                return here, point
            following = fit(there)
            if following.deviance <= here.deviance + ROUNDING * abs(here.deviance):
                break
            step = step / 2
        here, point = following, there
    return here, point


def _fit(
    ratios: Array,
    alike: tuple[Array, NDArray[np.intp], Array, Array],
    within: float,
    freedom: float,
) -> _Fit:
    """Return the fit at two ratios of variances.

    ``ratios`` are the participant and interaction components divided by the repetition variance.
    ``alike`` has one row for each group of people with the same counts: the counts, the number of
    people, and the sums and products of their cell means.
    """
    person, cell = ratios
    counts, people, sums, products = alike
    present = counts > 0
    spread = np.where(present, cell + 1 / np.where(present, counts, 1.0), 1.0)
    weights = present / spread
    each = weights.sum(axis=1)
    shrink = person / (1 + person * each)
    normal = np.diag(people @ weights) - (weights * (people * shrink)[:, None]).T @ weights
    weighted = (weights * sums).sum(axis=1)
    right = (weights * sums).sum(axis=0) - (shrink * weighted) @ weights
    levels = np.linalg.solve(normal, right)
    towards = np.einsum("gkl,gl->gk", products, weights)
    own = np.einsum("gkk->gk", products)
    quadratic = (weights * own).sum() - shrink @ (weights * towards).sum(axis=1) - right @ levels
    left = people @ present.sum(axis=1) - len(levels) + freedom
    scale = (quadratic + within) / left
    determinants = (
        people @ np.log(spread).sum(axis=1)
        + people @ np.log1p(person * each)
        + np.linalg.slogdet(normal)[1]
    )
    # A group's covariance matrix V, relative to the repetition variance, is `person` everywhere,
    # plus `cell + 1 / count` on the diagonal. Its inverse is diag(w) - shrink w w'. The gradient is
    # tr(people V^-1 dV) - tr(M V^-1 dV V^-1) with M = squared residuals / scale + people normal^-1.
    # dV is a matrix of ones for the participant component, and the identity for the interaction.
    # Only the diagonal of M and its product with w are needed.
    inverse = np.linalg.inv(normal)
    fitted = weights @ levels
    towards -= sums * fitted[:, None] + np.outer(weighted - people * fitted, levels)
    towards = towards / scale + people[:, None] * (weights @ inverse)
    own = (own - 2 * sums * levels + np.outer(people, levels**2)) / scale
    own += np.outer(people, np.diag(inverse))
    both, square = (weights * towards).sum(axis=1), weights**2
    length = square.sum(axis=1)
    cubes = (weights * square).sum(axis=1)
    total, diagonal = each / (1 + person * each), each - shrink * length
    across = people * total - both / (1 + person * each) ** 2
    along = people * diagonal - (square * own).sum(axis=1)
    along += 2 * shrink * (square * towards).sum(axis=1) - shrink**2 * length * both
    slopes = np.array([people @ total, people @ diagonal])
    total_of_squares = length - 2 * shrink * cubes + shrink**2 * length**2
    curvature = np.array(
        [
            [people @ total**2, people @ (length / (1 + person * each) ** 2)],
            [people @ (length / (1 + person * each) ** 2), people @ total_of_squares],
        ]
    )
    return _Fit(
        deviance=float(determinants + left * np.log(scale)),
        gradient=np.array([across.sum(), along.sum()]),
        curvature=curvature - np.outer(slopes, slopes) / left,
        scale=float(scale),
    )
