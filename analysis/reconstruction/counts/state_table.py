"""Count the combinations of values below or above a reference value, by dynamic programming.

The reference value is called the centre. A value at a distance of d steps from the centre adds (1,
d, w_d) to the state (k, a, w). Here, k is the number of values added so far, a is the sum of their
distances, and w = (q ± a)/2, where q is the sum of squared distances. The sign is positive below
the centre and negative above it. The table has w instead of q as its third index, because a and q
always have the same parity, so half of the cells in a table over (k, a, q) would be empty. The
triangular number w_d = d(d ± 1)/2 is the amount that a value adds to w.

A combination of values below the centre and a combination of values above it form a solution if
a_above = a_below + D and w_above = (V - D)/2 - w_below, where D and V are the required sums of
signed and squared distances. For multisets, the number of solutions is the sum of the products of
matching cells in the two state tables.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from math import comb
from typing import Any

import numpy as np
import numpy.typing as npt

from slipscale.analysis.reconstruction.counts.residues import WORD

Array = npt.NDArray[Any]


def multiset_ways(_k: int, _j: int) -> int:
    """Return 1, because the values in a multiset have no positions."""
    return 1


Ways = Callable[[int, int], int]
# Functions for the number of ways to place j equal values at k positions, keyed by measure.
WAYS: dict[str, Ways] = {"multisets": multiset_ways, "ordered": comb}


@dataclass(frozen=True)
class Shape:
    """The distances that a state table covers, and the size of the table.

    Parameters
    ----------
    nearest, farthest : int
        Range of distances from the centre, in steps. The range is empty if ``farthest < nearest``.
    sign : int
        +1 for values below the centre, -1 for values above it.
    reach : tuple of (int, int)
        Largest possible a and w (see the module docstring) of k values in a solution, for k = 0, 1,
        2, ...
    holes : frozenset of int
        Distances in this range that are excluded.
    """

    nearest: int
    farthest: int
    sign: int
    reach: tuple[tuple[int, int], ...]
    holes: frozenset[int] = frozenset()

    @cached_property
    def distances(self) -> tuple[int, ...]:
        """Permitted distances from the centre, in ascending order."""
        every = range(self.nearest, self.farthest + 1)
        return tuple(d for d in every if d not in self.holes)

    @property
    def cells(self) -> int:
        """Number of cells in the state table."""
        return sum((a + 1) * (w + 1) for a, w in self.reach)

    def triangle(self, distance: int) -> int:
        """Return the amount that one value at `distance` adds to w."""
        return distance * (distance + self.sign) // 2


class StateTable:
    """A table of the number of value combinations for each state (k, a, w).

    The states are defined in the module docstring. Values are added in order of decreasing distance
    from the centre (`advance`) and removed in order of increasing distance (`retreat`). Both
    methods change the table in place. Only a few values can be far from the centre, so most steps
    change only a small corner of the table.

    Parameters
    ----------
    shape : Shape
        Distances that the table covers, and size of the table.
    measure : {"multisets", "ordered"}
    modulus : int or None
        Modulus of all counts: 2**64 or a prime below 2**31. If None, counts are estimated in
        floating point.
    """

    def __init__(self, shape: Shape, measure: str, modulus: int | None) -> None:
        self.shape, self.measure, self.modulus = shape, measure, modulus
        kind = np.float64 if modulus is None else np.uint64
        self.width = np.array([w + 1 for _, w in shape.reach], dtype=np.int64)
        sizes = np.array([(a + 1) * (w + 1) for a, w in shape.reach], dtype=np.int64)
        self.start = np.concatenate(([0], np.cumsum(sizes)[:-1]))
        self.flat: Array = np.zeros(int(sizes.sum()), dtype=kind)
        self.planes: list[Array] = [
            self.flat[s : s + n].reshape(-1, w)
            for s, n, w in zip(self.start, sizes, self.width, strict=True)
        ]
        self.planes[0][0, 0] = 1
        self._filled = False
        # Upper bound on the counts in the table.
        self._ceiling = 1

    def distances(self) -> tuple[int, ...]:
        """Return the permitted distances in descending order."""
        return self.shape.distances[::-1]

    def fill(self) -> StateTable:
        """Fill the table with the counts for all distances, if it is not yet filled; return it."""
        if not self._filled:
            for distance in self.distances():
                self.advance(distance)
            self.reduce()
            self._filled = True
        return self

    def reduce(self) -> None:
        """Reduce every cell of the table modulo `modulus`."""
        if self.modulus in (None, WORD):
            return
        divisor = np.uint64(self.modulus or 0)
        for plane in self.planes:
            # This is four times as fast as the remainder operator.
            plane[...] -= plane // divisor * divisor
        self._ceiling = (self.modulus or 0) - 1

    def advance(self, distance: int) -> None:
        """Add values at `distance`, which must be smaller than all distances in the table."""
        top = len(self.planes) - 1
        if self.measure == "multisets":
            self._make_room(top + 1)
            for k in range(1, top + 1):
                for here, there in self._shifted(k, 1, distance):
                    here[...] += there
            return
        for k in range(top, 0, -1):
            for j in range(1, k + 1):
                for here, there in self._shifted(k, j, distance):
                    here[...] += self.scaled(there, comb(k, j))
                    self._settle(here)

    def retreat(self, distance: int) -> None:
        """Remove the values at `distance`, which must be the smallest distance in the table.

        This method reverses `advance`.
        """
        self._filled = False
        top = len(self.planes) - 1
        if self.measure == "multisets":
            for k in range(top, 0, -1):
                for here, there in self._shifted(k, 1, distance):
                    self._subtract(here, there)
            return
        for k in range(1, top + 1):
            for j in range(1, k + 1):
                for here, there in self._shifted(k, j, distance):
                    self._subtract(here, self.scaled(there, comb(k, j)))

    def pull_back(self, distance: int) -> None:
        """Apply the transpose of the linear map `advance` to a table of weights.

        The new weight of a state is the sum of the old weights of all states that result from
        adding zero or more values at `distance` from the centre. For ordered samples, each old
        weight is multiplied by the number of ways to choose positions for the added values. This
        method must not be used for tables of counts.
        """
        top = len(self.planes) - 1
        if self.measure == "multisets":
            for k in range(top, 0, -1):
                for here, there in self._shifted(k, 1, distance):
                    there[...] += here
                    self._settle(there)
            return
        for low in range(top):
            for j in range(1, top - low + 1):
                for here, there in self._shifted(low + j, j, distance):
                    there[...] += self.scaled(here, comb(low + j, j))
                    self._settle(there)

    def _shifted(self, k: int, j: int, distance: int) -> Iterator[tuple[Array, Array]]:
        """Yield the cells of states with k values, and of the states that remain without j of them.

        The j values lie at `distance` from the centre. All values are at least this far from the
        centre, which bounds a and w from below.
        """
        step_a, step_w = j * distance, j * self.shape.triangle(distance)
        low_a, low_w = k * distance, k * self.shape.triangle(distance)
        far, far_w = self.shape.farthest, self.shape.triangle(self.shape.farthest)
        high_a = min(self.shape.reach[k][0], self.shape.reach[k - j][0] + step_a, k * far)
        high_w = min(self.shape.reach[k][1], self.shape.reach[k - j][1] + step_w, k * far_w)
        if low_a <= high_a and low_w <= high_w:
            yield (
                self.planes[k][low_a : high_a + 1, low_w : high_w + 1],
                self.planes[k - j][
                    low_a - step_a : high_a - step_a + 1, low_w - step_w : high_w - step_w + 1
                ],
            )

    def _make_room(self, growth: int) -> None:
        """Reduce all counts modulo `modulus` if growth by the factor `growth` could overflow."""
        if self.modulus in (None, WORD):
            return
        if self._ceiling * growth >= WORD:
            self.reduce()
        self._ceiling *= growth

    def scaled(self, cells: Array, factor: int) -> Array:
        """Return `cells` times `factor`, reduced modulo `modulus`."""
        if self.modulus is None:
            weighted: Array = cells * float(factor)
            return weighted
        product: Array = cells * np.uint64(factor % self.modulus)
        return self._remainder(product)

    def _remainder(self, cells: Array) -> Array:
        if self.modulus in (None, WORD):
            return cells
        divisor = np.uint64(self.modulus or 0)
        rest: Array = cells - cells // divisor * divisor
        return rest

    def _settle(self, cells: Array) -> None:
        """Reduce sums of two residues in place, if the modulus is a prime."""
        if self.modulus not in (None, WORD):
            cells[...] = self._remainder(cells)
            self._ceiling = (self.modulus or 0) - 1

    def _subtract(self, cells: Array, part: Array) -> None:
        if self.modulus in (None, WORD):
            cells -= part
        else:
            cells += np.uint64(self.modulus or 0) - part
            self._settle(cells)
