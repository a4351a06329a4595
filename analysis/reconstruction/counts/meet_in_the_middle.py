"""Combine state tables for values below and above the centre into complete solutions.

Let c be the centre, a reference value on the scale (see `partition.Split`). For n free values with
sum S and sum of squares Q, the signed distances from c add up to D = S - nc, and the squared
distances add up to V = Q - 2cS + nc².
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import comb, isqrt

import numpy as np

from slipscale.analysis.reconstruction.counts.partition import Part, Split
from slipscale.analysis.reconstruction.counts.state_table import Array, Shape


@dataclass(frozen=True)
class Goal:
    """Required number of free values, and required sums of their distances from the centre.

    Free values and parts are defined in `partition`. The centre is a reference value on the scale.

    Parameters
    ----------
    part : Part
        The part whose free values must meet these requirements.
    n : int
        Number of free values.
    signed_sum : int
        Sum D of the free values' signed distances from the centre.
    square_sum : int
        Sum V of the free values' squared distances from the centre, which has the same parity as D.
    """

    part: Part
    n: int
    signed_sum: int
    square_sum: int

    @property
    def numbers_above(self) -> range:
        """Possible numbers of free values at or above the centre."""
        return range(self.n - self.part.most_below, self.n - self.part.fewest_below + 1)


def goals(parts: Iterable[Part]) -> dict[Split, list[Goal]]:
    """Convert parts to `Goal` objects, grouped by `Split`.

    A part without solutions is omitted if its sum of squared distances is negative or has the wrong
    parity.
    """
    groups: dict[Split, list[Goal]] = {}
    for part in parts:
        n, total, squares = part.moments.n, part.moments.total, part.moments.squares
        c = part.split.centre
        signed_sum = total - n * c
        square_sum = squares - 2 * c * total + n * c * c
        if square_sum >= 0 and (square_sum - signed_sum) % 2 == 0:
            groups.setdefault(part.split, []).append(Goal(part, n, signed_sum, square_sum))
    return groups


def shapes(split: Split, wanted: list[Goal]) -> tuple[Shape, Shape]:
    """Return the shapes of the two state tables needed to count the solutions of `wanted`."""
    below, above = _halves(split, wanted)
    return (
        below.shape(frozenset(split.centre - value for value in split.holes)),
        above.shape(frozenset(value - split.centre for value in split.holes)),
    )


def glimpses(split: Split, wanted: list[Goal]) -> list[Glimpse]:
    """Return the sizes of some planes of both state tables (see `Glimpse`)."""
    return [half.glimpse() for half in _halves(split, wanted)]


# Maximum numbers of planes, sums per plane and distances that are sampled for a `Glimpse`.
PLANES_LOOKED_AT = 16
SUMS_LOOKED_AT = 256
DISTANCES_LOOKED_AT = 1024


@dataclass(frozen=True)
class Glimpse:
    """Sizes of some planes of a state table, for a quick estimate of the table's total size.

    A plane consists of the cells for a given number k of values.

    Parameters
    ----------
    ks : ndarray, shape (planes,)
        The number k that defines each sampled plane.
    cells : ndarray, shape (planes,)
        Number of cells of each sampled plane.
    sizes : ndarray, shape (planes, distances)
        Number of cells of each sampled plane that are needed if all values are at least a certain
        distance from the centre, for a sample of distances.
    share : float
        Ratio of the number of distances to the number of sampled distances.
    """

    ks: Array
    cells: Array
    sizes: Array
    share: float


@dataclass(frozen=True)
class _Half:
    """The values on one side of the centre, and the bounds on their sums in any solution.

    If k values in [low, high] have the sum a, their sum of squares is at least a²/k and at most
    (low + high) a - k low high. The same bounds apply to the remaining n - k values. All n values
    together must have the sums D and V (see `Goal`).
    """

    nearest: int
    farthest: int
    sign: int
    lowest: int  # Smallest remaining distance; negative on the other side.
    most: int  # Largest number of values.
    # For each n: n, the smallest and largest D, and the smallest and largest V of the goals.
    groups: tuple[tuple[int, tuple[int, int], tuple[int, int]], ...]

    def shape(self, holes: frozenset[int]) -> Shape:
        """Return the shape of the state table for these values, excluding the `holes`."""
        reach = ((0, 0), *(self._reach_of(k, 0) for k in range(1, self.most + 1)))
        own = frozenset(d for d in holes if self.nearest <= d <= self.farthest)
        return Shape(self.nearest, self.farthest, self.sign, reach, own)

    def glimpse(self) -> Glimpse:
        """Return the sizes of some planes of the state table for these values."""
        ks = np.unique(np.linspace(0, self.most, PLANES_LOOKED_AT).astype(int))
        found = [self._reach_of(int(k), SUMS_LOOKED_AT) if k else (0, 0) for k in ks]
        a, w = np.array(found, dtype=np.float64).T[:, :, None]
        number = max(self.farthest - self.nearest + 1, 0)
        d = np.linspace(self.nearest, self.farthest, min(number, DISTANCES_LOOKED_AT))
        rows, columns = a + 1 - ks[:, None] * d, w + 1 - ks[:, None] * (d * (d + self.sign) / 2)
        return Glimpse(
            ks,
            ((a + 1) * (w + 1))[:, 0],
            np.maximum(rows, 0) * np.maximum(columns, 0),
            number / max(len(d), 1),
        )

    def _reach_of(self, k: int, looked_at: int) -> tuple[int, int]:
        """Return the largest a and w (see `state_table`) that k values can have in a solution.

        If `looked_at` is not 0, at most this number of values of a is examined.
        """
        largest = (0, 0)
        for n, signed_sums, square_sums in self.groups:
            if k > n:
                continue
            first, last = k * self.nearest, min(k * self.farthest, isqrt(k * square_sums[1]))
            if last < first:
                continue
            if looked_at and last - first >= looked_at:
                a = np.linspace(first, last, looked_at).astype(np.int64)
            else:
                a = np.arange(first, last + 1, dtype=np.int64)
            rest = n - k
            # Limits on the sum of the remaining distances, which are positive on this side of the
            # centre.
            ends = sorted(-self.sign * signed_sum for signed_sum in signed_sums)
            b_least, b_most = ends[0] - a, ends[1] - a
            nearest_to_0 = np.clip(0, b_least, b_most)
            rest_least = -(-(nearest_to_0**2) // max(rest, 1))
            total, inner = self.lowest + self.farthest, rest * self.lowest * self.farthest
            rest_most = np.maximum(total * b_least, total * b_most) - inner
            own = (self.nearest + self.farthest) * a - k * self.nearest * self.farthest
            most = np.minimum(own, square_sums[1] - rest_least)
            least = np.maximum(-(-(a * a) // k), square_sums[0] - rest_most)
            fits = (
                (least <= most) & (b_most >= rest * self.lowest) & (b_least <= rest * self.farthest)
            )
            if fits.any():
                w = (most + self.sign * a)[fits] // 2
                largest = (max(largest[0], int(a[fits].max())), max(largest[1], int(w.max())))
        return largest


def _halves(split: Split, wanted: list[Goal]) -> tuple[_Half, _Half]:
    below = (split.centre - split.below, split.centre - split.low)
    above = (split.above - split.centre, split.high - split.centre)
    of_n: dict[int, list[Goal]] = {}
    for goal in wanted:
        of_n.setdefault(goal.n, []).append(goal)
    groups = tuple(
        (n, _ends([g.signed_sum for g in found]), _ends([g.square_sum for g in found]))
        for n, found in of_n.items()
    )
    most_below = max(goal.part.most_below for goal in wanted)
    most_above = max(goal.n - goal.part.fewest_below for goal in wanted)
    return _half(below, above, +1, most_below, groups), _half(above, below, -1, most_above, groups)


def _ends(values: list[int]) -> tuple[int, int]:
    return min(values), max(values)


def _half(
    own: tuple[int, int],
    other: tuple[int, int],
    sign: int,
    most: int,
    groups: tuple[tuple[int, tuple[int, int], tuple[int, int]], ...],
) -> _Half:
    here = own[1] >= own[0]
    lowest = -other[1] if other[1] >= other[0] else own[0]
    return _Half(*own, sign, lowest, most if here else 0, groups)


@dataclass(frozen=True)
class Joint:
    """Two slices of the state tables below and above the centre, aligned cell by cell.

    Values from two cells at the same position together have the sums that `goal` requires. For
    ordered samples, `ways` is the number of ways to interleave the values below the centre, the
    values above it and the fixed values. Multisets have no order, so `ways` is 1.
    """

    goal: Goal
    k_below: int
    k_above: int
    first_a_above: int
    first_w_above: int
    below: Array
    above: Array
    ways: int


def joints(
    goal: Goal,
    outlines: tuple[Shape, Shape],
    planes: tuple[list[Array], list[Array]],
    measure: str,
) -> Iterator[Joint]:
    """Yield aligned slices of the two state tables for each number of values above the centre."""
    (shape_below, shape_above), (planes_below, planes_above) = outlines, planes
    constant = (goal.square_sum - goal.signed_sum) // 2
    for k in goal.numbers_above:
        m = goal.n - k
        if k >= len(shape_above.reach) or m >= len(shape_below.reach):
            continue
        (high_a, high_w), (high_b, high_v) = shape_above.reach[k], shape_below.reach[m]
        a = (max(0, goal.signed_sum), min(high_a, high_b + goal.signed_sum))
        w = (max(0, constant - high_v), min(high_w, constant))
        if a[0] > a[1] or w[0] > w[1]:
            continue
        above = planes_above[k][a[0] : a[1] + 1, w[0] : w[1] + 1]
        rows = planes_below[m][a[0] - goal.signed_sum : a[1] - goal.signed_sum + 1]
        below = rows[:, constant - w[1] : constant - w[0] + 1][:, ::-1]
        ways = goal.part.arrangements * comb(goal.n, k) if measure == "ordered" else 1
        yield Joint(goal, m, k, a[0], w[0], below, above, ways)
