"""Two columns paired so that their products have a wanted sum: found by exchanging ratings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.inference.bounds import as_table
from slipscale.analysis.reconstruction.inference.comparable_columns import values_of

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
    from slipscale.analysis.reconstruction.inference.conclusions import Ratings

# Pairs of sums and sums of squares that tables are sought for, and data sets that are drawn and
# paired for each.
SOUGHT = 20
DRAWN = 2000
PAIRED = 50


@dataclass(frozen=True)
class Pair:
    """A sum and a sum of squares of either column, and the sums of products that fit."""

    sums: tuple[int, int]
    squares: tuple[int, int]
    roots: tuple[float, float]
    products: range

    def correlations(self, n: int) -> tuple[float, float]:
        """Return the least and the largest correlation."""
        bottom = self.roots[0] * self.roots[1]
        found = [
            (n * value - self.sums[0] * self.sums[1]) / bottom
            for value in (self.products[0], self.products[-1])
        ]
        return found[0], found[1]


def example(columns: list[Solutions], pairs: list[Pair]) -> Ratings:
    """Return ratings that print the test; empty if a search finds none."""
    if any(solutions.not_drawn for solutions in columns):
        return ()
    generator = np.random.default_rng(1)
    drawn = [Sampler(solutions).draw(DRAWN, generator).astype(np.int64) for solutions in columns]
    for pair in pairs[:SOUGHT]:
        rows = [
            x[(x.sum(axis=1) == total) & ((x**2).sum(axis=1) == squares)]
            for x, total, squares in zip(drawn, pair.sums, pair.squares, strict=True)
        ]
        for x, y in zip(*(part[:PAIRED] for part in rows), strict=False):
            for start in (np.sort(y), np.sort(y)[::-1], generator.permutation(y)):
                found = _exchange(np.sort(x), start.copy(), pair.products)
                if found is not None:
                    tables = as_table(np.sort(x), found)
                    return tuple(
                        tuple(float(v) for v in values_of(solutions, np.array(row)))
                        for solutions, row in zip(columns, tables, strict=True)
                    )
    return ()


def _exchange(x: Array, y: Array, products: range) -> Array | None:
    """Return `y` rearranged so that its products with `x` add up to one of `products`, or None.

    By the exchange of two ratings that comes nearest, as long as one comes nearer.
    """
    gains = np.subtract.outer(x, x)
    for _ in range(len(x) ** 2):
        missing = _missing(int(x @ y), products)
        if not missing:
            return y
        # y[i] and y[j] exchanged add (x_i - x_j) (y_j - y_i).
        change = -gains * np.subtract.outer(y, y)
        left = np.abs(missing - change)
        place = int(left.argmin())
        if left.flat[place] >= abs(missing):
            return None
        i, j = divmod(place, len(x))
        y[i], y[j] = y[j], y[i]
    return None


def _missing(value: int, products: range) -> int:
    """Return how far a sum of products is from those that fit."""
    return max(products[0] - value, 0) or min(products[-1] - value, 0)
