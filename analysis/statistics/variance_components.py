"""Estimate variance components from unbalanced repeated estimates by REML.

The model is: log estimate = mean of the level + participant + participant x level + repetition.
Restricted maximum likelihood needs only the mean and number of estimates per participant and level,
and the sum of squares around these means (Searle, Casella and McCulloch 1992, Variance Components,
ch. 6). If all participants have the same number of repetitions at every level and no component is
negative, the result equals the mean-squares estimate.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.statistics.arrays import Array

#: Starting values of the search: the participant and interaction components, each relative to the
#: repetition variance.
STARTS = ((1.0, 0.5), (0.05, 0.05))


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
    from scipy import optimize

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
    alike = (counts, people, sums, products)
    found = min(
        (
            optimize.minimize(
                lambda ratios: _deviance(ratios, *alike, within, freedom)[:2],
                start,
                jac=True,
                bounds=[(0, None)] * 2,
                options={"ftol": 1e-15, "gtol": 1e-8},
            )
            for start in starts
        ),
        key=lambda each: float(each.fun),
    )
    scale = _deviance(found.x, *alike, within, freedom)[2]
    return np.array([*found.x, 1.0]) * scale


def _deviance(  # noqa: PLR0917
    ratios: Array,
    counts: Array,
    people: NDArray[np.intp],
    sums: Array,
    products: Array,
    within: float,
    freedom: float,
) -> tuple[float, Array, float]:
    """Return -2 log restricted likelihood (no constant), its gradient and the repetition variance.

    ``ratios`` are the participant and interaction components divided by the repetition variance,
    which follows from the ratios by a closed formula. Each row of ``counts`` describes a group of
    ``people`` with the same counts. ``sums`` and ``products`` refer to the cell means of the group.
    """
    person, cell = ratios
    present = counts > 0
    spread = np.where(present, cell + 1 / np.where(present, counts, 1.0), 1.0)
    weights = present / spread
    each = weights.sum(axis=1)
    shrink = person / (1 + person * each)
    normal = np.diag(people @ weights) - (weights * (people * shrink)[:, None]).T @ weights
    right = (weights * sums).sum(axis=0) - (shrink * (weights * sums).sum(axis=1)) @ weights
    levels = np.linalg.solve(normal, right)
    squares = np.einsum("gk,gkl,gl->g", weights, products, weights)
    quadratic = np.einsum("gk,gkk->", weights, products) - shrink @ squares - right @ levels
    left = people @ present.sum(axis=1) - len(levels) + freedom
    scale = (quadratic + within) / left
    determinants = (
        people @ np.log(spread).sum(axis=1)
        + people @ np.log1p(person * each)
        + np.linalg.slogdet(normal)[1]
    )
    # A group's covariance matrix V, relative to the repetition variance, is `person` everywhere,
    # plus `cell + 1 / count` on the diagonal.
    inverse = weights[:, :, None] * np.eye(len(levels))
    inverse -= shrink[:, None, None] * weights[:, :, None] * weights[:, None, :]
    across = sums[:, :, None] * levels
    squared = products - across - across.swapaxes(1, 2)
    squared += people[:, None, None] * np.outer(levels, levels)
    # The gradient is tr(A dV) with A = people V^-1 - V^-1 (squared / scale + people normal^-1)
    # V^-1. dV is a matrix of ones for the participant component, and the identity for the
    # interaction.
    middle = squared / scale + people[:, None, None] * np.linalg.inv(normal)
    slope = people[:, None, None] * inverse - inverse @ middle @ inverse
    gradient = np.array([slope.sum(), np.einsum("gkk->", slope)])
    return float(determinants + left * np.log(scale)), gradient, float(scale)
