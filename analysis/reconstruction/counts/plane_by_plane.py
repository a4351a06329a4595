"""Count the multisets with given sums, storing only one two-dimensional table per distance.

To draw samples and compute marginals, `state_table` stores the states for every number of values k.
Counting does not require all of these states. Let T_k[d] be the table of counts, called a plane,
for k values at distances of at least d from the centre (see `state_table` for a, w and w_d). The
nearest value is either at d or farther out, so

    T_k[d](a, w) = T_k[d + 1](a, w) + T_{k-1}[d](a - d, w - w_d).

If the tables are indexed by i = a - k d and j = w - k w_d, the left side and the second term of
this equation have the same indices (i, j). The table is therefore updated in place, by adding
T_k[d + 1] at the offset (k, k (w_{d+1} - w_d)). The recursion corresponds to enumerating conjugate
partitions. Tables for values far from the centre are small, and they are needed only for small k.

The recursion is used for values above the centre, with k ascending. For values below the centre,
the transposed recursion is used, with k descending, and the tables contain weights instead of
counts. The weight of a state is the number of ways to complete this state to a solution by adding
further values. At every k, the counts above the centre are added to the weights below it, so that
no complete table needs to be stored.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from slipscale.analysis.reconstruction.counts.meet_in_the_middle import Goal
from slipscale.analysis.reconstruction.counts.residues import WORD
from slipscale.analysis.reconstruction.counts.state_table import Array, Shape


def number(below: Shape, above: Shape, goals: Sequence[Goal], modulus: int | None) -> float | int:
    """Return the number of multisets that satisfy any of `goals`, modulo `modulus`.

    Parameters
    ----------
    below, above : Shape
        Shapes of the state tables for values below and above the centre.
    goals : sequence of Goal
        Requirements on the free values, one `Goal` per part.
    modulus : int or None
        Modulus of the result: 2**64 or a prime below 2**31. If None, the result is an estimate in
        floating point.
    """
    found: float | int = 0
    for n in sorted({goal.n for goal in goals}):
        of_n = [goal for goal in goals if goal.n == n]
        found += _Meeting(below, above, modulus).number(n, of_n)
    return found if modulus is None else int(found) % modulus


def cells(below: Shape, above: Shape, goals: Iterable[Goal]) -> int:
    """Return the maximum number of table cells that are in memory at the same time."""
    most = 0
    for n in {goal.n for goal in goals}:
        alive = np.zeros(n + 1, dtype=np.int64)
        for place, (last, size) in enumerate(_lives(above)):
            # Counts and weights are combined in the nearest plane, which is therefore needed for
            # all k.
            alive[: (last if place else n) + 1] += size
        for last, size in _lives(below):
            # All of the n values that are not above the centre are below the centre.
            alive[max(n - last, 0) :] += size
        most = max(most, int(alive.max()))
    return most


def roundings(below: Shape, above: Shape, goals: Sequence[Goal]) -> int:
    """Return the maximum number of floating-point roundings that affect a term of a count."""
    distances = sum(len(half.distances) for half in (below, above))
    return (len(above.reach) + len(below.reach)) * (len(goals) + 2) + 2 * distances + 8


def _lives(shape: Shape) -> list[tuple[int, int]]:
    """Return the largest k for which each plane is needed, and the plane's number of cells."""
    return [(last, (i + 1) * (j + 1)) for last, i, j in _extents(shape)]


def _extents(shape: Shape) -> list[tuple[int, int, int]]:
    """Return the largest k, i and j (see the module docstring) of the plane for each distance."""
    if not shape.distances:
        return []
    k, d = np.arange(len(shape.reach))[:, None], np.array(shape.distances, dtype=np.int64)
    a, w = np.array(shape.reach, dtype=np.int64).T[:, :, None]
    i, j = a - k * d, w - k * (d * (d + shape.sign) // 2)
    inside = (i >= 0) & (j >= 0)
    found = (np.where(inside, values, -1).max(axis=0).tolist() for values in (k, i, j))
    return list(zip(*found, strict=True))


@dataclass
class _Plane:
    """The plane T_k[d] (see the module docstring) for one distance d and the current k."""

    distance: int
    last: int
    values: Array


class _Half:
    """All planes for values on one side of the centre, in ascending order of distance."""

    def __init__(self, shape: Shape, kind: type) -> None:
        self.shape = shape
        self.planes = []
        for d, (last, most_i, most_j) in zip(shape.distances, _extents(shape), strict=True):
            self.planes.append(_Plane(d, last, np.zeros((most_i + 1, most_j + 1), dtype=kind)))

    def extent(self, place: int, k: int) -> tuple[int, int]:
        """Return how many rows and columns of ``planes[place]`` are needed for k values."""
        a, w = self.shape.reach[k]
        d = self.planes[place].distance
        i, j = a - k * d + 1, w - k * self.shape.triangle(d) + 1
        return (i, j) if i > 0 and j > 0 else (0, 0)

    def between(self, place: int, k: int) -> tuple[Array, Array] | None:
        """Return the cells of a plane for k values, and the same states in the next nearer plane.

        Returns None if there are no such cells in ``planes[place]``.
        """
        rows, columns = self.extent(place, k)
        if not rows:
            return None
        far, near = self.planes[place], self.planes[place - 1]
        down = k * (far.distance - near.distance)
        right = k * (self.shape.triangle(far.distance) - self.shape.triangle(near.distance))
        return (
            far.values[:rows, :columns],
            near.values[down : down + rows, right : right + columns],
        )

    def reduce(self, modulus: int, k: int) -> None:
        """Reduce all counts modulo `modulus` in the planes needed for k or more values."""
        divisor = np.uint64(modulus)
        for plane in self.planes:
            # Rows are processed separately to keep temporary arrays small.
            for row in plane.values if plane.last >= k else ():
                np.subtract(row, row // divisor * divisor, out=row)


@dataclass(frozen=True)
class _Run:
    """Goals that differ only in V; (V - D) / 2 takes all integers from `first` to `last`."""

    signed_sum: int
    numbers_above: range
    first: int
    last: int


def _runs(goals: Iterable[Goal]) -> list[_Run]:
    groups: dict[tuple[int, range], list[int]] = {}
    for goal in goals:
        constant = (goal.square_sum - goal.signed_sum) // 2
        groups.setdefault((goal.signed_sum, goal.numbers_above), []).append(constant)
    found = []
    for key, constants in groups.items():
        ordered = sorted(constants)
        breaks = [i for i in range(1, len(ordered)) if ordered[i] != ordered[i - 1] + 1]
        for first, end in pairwise([0, *breaks, len(ordered)]):
            found.append(_Run(*key, ordered[first], ordered[end - 1]))
    return found


class _Meeting:
    """State of the count while the number of values above the centre increases from 0 to n."""

    def __init__(self, below: Shape, above: Shape, modulus: int | None) -> None:
        kind = np.float64 if modulus is None else np.uint64
        self.modulus = modulus
        self.below, self.above = _Half(below, kind), _Half(above, kind)
        self.none = np.ones((1, 1), dtype=kind)  # There is one way to choose no values.
        for plane in self.above.planes:
            if plane.values.size:
                plane.values[0, 0] = 1
        # Upper bounds on the counts above the centre and the weights below it.
        self.ceilings = (1, 0)

    def number(self, n: int, goals: list[Goal]) -> float | int:
        """Return the number of multisets of n values that satisfy any of `goals`."""
        found: float | int = 0
        runs = _runs(goals)
        for k in range(n + 1):
            left = n - k
            self._make_room(len(goals), left)
            if 0 < k < len(self.above.shape.reach):
                self._enter(k)
            for run in runs:
                if k in run.numbers_above:
                    found += self._meet(run, k, left)
            if 0 < left < len(self.below.shape.reach):
                self._leave(left)
        ends = [plane.values[0, 0] for plane in self.below.planes if plane.values.size]
        return found + sum(end if self.modulus is None else int(end) for end in ends)

    def _enter(self, k: int) -> None:
        """Update the planes above the centre from counts for k - 1 values to k values."""
        planes = self.above.planes
        for place in range(len(planes) - 1, 0, -1):
            if pair := self.above.between(place, k):
                far, near = pair
                near += far
        for plane in planes[1:]:
            if plane.last <= k:
                plane.values = plane.values[:0, :0]

    def _leave(self, k: int) -> None:
        """Update the planes below the centre from weights for k values to k - 1 values."""
        for place in range(1, len(self.below.planes)):
            pair = self.below.between(place, k)
            if pair is None:
                break
            far, near = pair
            far += near

    def _meet(self, run: _Run, k: int, left: int) -> float | int:
        """Add the counts for k values above the centre to the weights for `left` values below it.

        Only states that together satisfy a goal in `run` are combined. If `left` is 0, the sum of
        the counts is returned and no weight is changed; otherwise 0 is returned.
        """
        above, below = self.above.shape, self.below.shape
        if k >= len(above.reach) or left >= len(below.reach):
            return 0
        if (k and not self.above.planes) or (left and not self.below.planes):
            return 0
        (high_a, high_w), (high_b, high_v) = above.reach[k], below.reach[left]
        low_a, low_w = _lowest(above, k)
        low_b, low_v = _lowest(below, left)
        a = max(low_a, low_b + run.signed_sum), min(high_a, high_b + run.signed_sum)
        w = max(low_w, run.first - high_v), min(high_w, run.last - low_v)
        if a[0] > a[1] or w[0] > w[1]:
            return 0
        source = self.above.planes[0].values if k else self.none
        overlap = source[a[0] - low_a : a[1] - low_a + 1, w[0] - low_w : w[1] - low_w + 1]
        # A state below with w = v matches states above with w from run.first - v to run.last - v.
        v = max(low_v, run.first - w[1]), min(high_v, run.last - w[0])
        before, after = w[0] - (run.first - v[1]), run.last - v[0] - w[1]
        worth = _window(overlap, before, after, run.last - run.first + 1)[:, ::-1]
        if not left:
            return float(worth.sum()) if self.modulus is None else int(worth.sum())
        row = a[0] - run.signed_sum - low_b
        target = self.below.planes[0].values[row : row + worth.shape[0]]
        target[:, v[0] - low_v : v[1] - low_v + 1] += worth
        return 0

    def _make_room(self, goals: int, left: int) -> None:
        """Reduce all counts modulo `modulus` if the next step could overflow."""
        if self.modulus in (None, WORD):
            return
        above, below = self._grown(*self.ceilings, goals)
        if max(above, below) >= WORD:
            for half, numbers in ((self.above, 0), (self.below, left)):
                half.reduce(self.modulus or 0, numbers)
            largest = (self.modulus or 0) - 1
            above, below = self._grown(largest, largest, goals)
        self.ceilings = above, below

    def _grown(self, above: int, below: int, goals: int) -> tuple[int, int]:
        """Return bounds on counts above the centre and weights below it after the next step.

        A step can add the counts of all farther planes to each plane above the centre. It can add
        the weights of all nearer planes, and one count per goal, to each plane below the centre.
        """
        grown = above * (len(self.above.planes) + 1)
        return grown, (below + goals * grown) * (len(self.below.planes) + 1)


def _window(cells: Array, before: int, after: int, length: int) -> Array:
    """Return the sum of each run of `length` adjacent columns, after padding with zeros.

    Sums of 1, 2, 4, ... columns are computed by doubling.
    """
    if length == 1:
        return cells
    width = before + cells.shape[1] + after - length + 1
    sums = np.zeros((cells.shape[0], width + length - 1), dtype=cells.dtype)
    sums[:, before : before + cells.shape[1]] = cells
    found = np.zeros((cells.shape[0], width), dtype=cells.dtype)
    covered, size = 0, 1
    while True:
        if length & size:
            found += sums[:, covered : covered + width]
            covered += size
        if 2 * size > length:
            return found
        sums = sums[:, :-size] + sums[:, size:]
        size *= 2


def _lowest(shape: Shape, k: int) -> tuple[int, int]:
    """Return the smallest possible a and w (see `state_table`) of k values."""
    nearest = shape.distances[0] if shape.distances else shape.nearest
    return k * nearest, k * shape.triangle(nearest)
