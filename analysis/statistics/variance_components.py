"""Components of variance of unbalanced repeated estimates, by restricted maximum likelihood.

Model: log estimate = mean of the level + participant + participant x level + repetition. Only means
and counts of cells (participant x level) enter, and the sum of squares within cells. The fit is
equal to the mean squares' if every cell has as many repetitions and no component is below 0.
Searle, Casella and McCulloch 1992, Variance Components, ch. 6.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

#: Where the search begins: the two components over the repetitions' variance.
STARTS = ((1.0, 0.5), (0.05, 0.05))


def reml_components(
    means: Array, counts: Array, squares: Array, starts: Sequence[Sequence[float]] = STARTS
) -> Array:
    """Return the components participant, participant x level and repetition; none is below 0.

    Parameters
    ----------
    means : array, shape (participants, levels)
        Mean of each cell; any number in an empty one.
    counts : array, shape (participants, levels)
        Estimates in each cell; 0 in an empty one.
    squares : array, shape (participants,)
        Each participant's sum of squares around the means of their cells.
    starts : sequence of (float, float)
        Where the search begins.
    """
    from scipy import optimize  # noqa: PLC0415 - half a second's import

    used = (counts > 0).any(axis=0)
    own, cells = np.where(counts > 0, means, 0.0)[:, used], counts[:, used]
    within, freedom = squares.sum(), counts.sum() - (counts > 0).sum()
    found = min(
        (
            optimize.minimize(
                lambda ratios: _deviance(ratios, own, cells, within, freedom)[0],
                start,
                bounds=[(0, None)] * 2,
                options={"ftol": 1e-15, "gtol": 1e-8},
            )
            for start in starts
        ),
        key=lambda each: float(each.fun),
    )
    scale = _deviance(found.x, own, cells, within, freedom)[1]
    return np.array([*found.x, 1.0]) * scale


def _deviance(
    ratios: Array, means: Array, counts: Array, within: float, freedom: float
) -> tuple[float, float]:
    """Return -2 log restricted likelihood, less a constant, and the repetitions' variance.

    ``ratios`` are the other components over that variance, which has a closed form.
    """
    person, cell = ratios
    there = counts > 0
    spread = np.where(there, cell + 1 / np.where(there, counts, 1.0), 1.0)
    weights = there / spread
    shrink = person / (1 + person * weights.sum(axis=1))
    normal = np.diag(weights.sum(axis=0)) - (weights * shrink[:, None]).T @ weights
    total = (weights * means).sum(axis=1)
    right = (weights * means).sum(axis=0) - (shrink * total) @ weights
    levels = np.linalg.solve(normal, right)
    quadratic = (weights * means**2).sum() - (shrink * total**2).sum() - right @ levels
    left = there.sum() - len(levels) + freedom
    scale = (quadratic + within) / left
    determinants = (
        np.log(spread).sum()
        + np.log1p(person * weights.sum(axis=1)).sum()
        + np.linalg.slogdet(normal)[1]
    )
    return float(determinants + left * np.log(scale)), float(scale)
