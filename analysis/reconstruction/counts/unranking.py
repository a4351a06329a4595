"""Find the solution with a given rank by reversing the dynamic programming of the count.

The additions that filled the state tables are undone one distance at a time, starting with the
distance nearest to the centre. At each distance, the tables give the number of solutions that
contain this distance exactly 0, 1, 2, ... times. The rank determines which of these cases applies.
All arithmetic uses integers, so uniformly distributed random ranks select all solutions with
exactly the same probability.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from slipscale.analysis.reconstruction.counts.residues import WORD, weights
from slipscale.analysis.reconstruction.counts.state_table import WAYS, Array, StateTable, Ways

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.meet_in_the_middle import Joint
    from slipscale.analysis.reconstruction.counts.problem import Problem

# Finished solutions are dropped from the arrays if the proportion of unfinished solutions is below
# this value.
WORTH_DROPPING = 0.7


class Ranking:
    """A numbering of the solutions of one problem, starting from 0.

    Parameters
    ----------
    task : Problem
        Problem whose solutions are numbered.
    measure : {"multisets", "ordered"}
        Whether to number multisets or ordered samples. Each multiset has one number per arrangement
        of its values if ordered samples are numbered.
    moduli : tuple of int
        Moduli of the counts. The product of the moduli must exceed every count.
    """

    def __init__(self, task: Problem, measure: str, moduli: tuple[int, ...]) -> None:
        self.measure, self.moduli = measure, moduli
        pairs = [task.tables(measure, modulus) for modulus in moduli]
        self._below, self._above = [p[0] for p in pairs], [p[1] for p in pairs]
        self._task = task
        # The first modulus determines which joints exist; counts are computed from all moduli.
        joints = [task.joints(*pair) for pair in pairs]
        self._joints: list[Joint] = []
        places, counts = [], []
        for same in zip(*joints, strict=True):
            below = self._whole([joint.below for joint in same])
            above = self._whole([joint.above for joint in same])
            row, column = np.nonzero((below != 0) & (above != 0))
            if len(row):
                pair_counts = below[row, column] * above[row, column]
                counts.append(pair_counts * self._number(same[0].ways))
                places.append(np.stack([np.full_like(row, len(self._joints)), row, column], axis=1))
                self._joints.append(same[0])
        self._places: Array = np.concatenate(places) if places else np.zeros((0, 3), dtype=np.int64)
        self._ends: Array = np.cumsum(np.concatenate(counts)) if counts else np.zeros(0, int)

    @property
    def total(self) -> int:
        """Number of solutions."""
        return int(self._ends[-1]) if len(self._ends) else 0

    def solutions(self, ranks: Array) -> Array:
        """Return the solutions numbered `ranks`, as one sorted row of ratings per solution.

        Ratings are given as numbers of scale steps above the minimum of the scale.

        Parameters
        ----------
        ranks : ndarray, shape (m,)
            Ranks from 0 to ``total - 1``, in ascending order.

        Returns
        -------
        ndarray of int32, shape (m, n)
        """
        # `_walk` empties the tables, so each call fills them again.
        for table in (*self._below, *self._above):
            table.fill()
        cell = np.searchsorted(self._ends, ranks, side="right")
        before = self._ends[cell - 1]
        before[cell == 0] = 0
        which, row, column = self._places[cell].T
        joined = np.array(
            [
                (j.k_below, j.k_above, j.first_a_above, j.first_w_above, j.goal.signed_sum,
                 (j.goal.square_sum - j.goal.signed_sum) // 2)
                for j in self._joints
            ],
            dtype=np.int64,
        )  # fmt: skip
        k_below, k_above, first_a, first_w, signed_sum, constant = joined[which].T
        a, w = first_a + row, first_w + column
        ways = np.array([self._number(j.ways) for j in self._joints], dtype=ranks.dtype)[which]
        rest = (ranks - before) // ways
        above_count = self._gather(self._above, k_above, a, w)
        rank_below, rank_above = rest // above_count, rest % above_count
        n = self._size()
        out = np.empty((len(ranks), n), dtype=np.int32)
        self._walk(self._below, (k_below, a - signed_sum, constant - w), rank_below, out)
        self._walk(self._above, (k_above, a, w), rank_above, out)
        self._give(which, out)
        if any(joint.goal.part.given for joint in self._joints):
            out.sort(axis=1)
        return out

    def _size(self) -> int:
        joint = self._joints[0]
        return joint.goal.n + sum(times for _, times in joint.goal.part.given)

    def _give(self, which: Array, out: Array) -> None:
        """Insert the fixed values between the free values below and above the centre."""
        for index, joint in enumerate(self._joints):
            rows = np.flatnonzero(which == index)
            column = joint.k_below
            for value, times in joint.goal.part.given:
                out[rows, column : column + times] = value
                column += times

    def _walk(
        self,
        tables: list[StateTable],
        state: tuple[Array, Array, Array],
        rank: Array,
        out: Array,
    ) -> None:
        """Write the values on one side of the centre, in ascending order of distance."""
        centre, end = self._task.split.centre, out.shape[1]
        sign = -tables[0].shape.sign
        shape, ways = tables[0].shape, WAYS[self.measure]
        rows = np.flatnonzero(state[0] > 0)
        k, a, w, rank = (part[rows] for part in (*state, rank))
        place = self._place(tables[0], k, a, w)
        for distance in reversed(tables[0].distances()):
            for table in tables:
                table.retreat(distance)
            without = self._whole([table.flat.take(place) for table in tables])
            movers = np.flatnonzero(rank >= without)
            rest, now = rank[movers] - without[movers], movers
            copies = 0
            while len(now):
                copies += 1
                here_k = k[now] - copies
                out[rows[now], here_k if sign < 0 else end - 1 - here_k] = centre + sign * distance
                here_a = a[now] - copies * distance
                here_w = w[now] - copies * shape.triangle(distance)
                factor = _factors(ways, k[now], copies, rank.dtype)
                block = self._gather(tables, here_k, here_a, here_w) * factor
                stay = rest < block
                done, go = now[stay], ~stay
                k[done], a[done], w[done] = here_k[stay], here_a[stay], here_w[stay]
                rank[done] = rest[stay] // factor[stay]
                rest, now = rest[go] - block[go], now[go]
            place[movers] = self._place(tables[0], k[movers], a[movers], w[movers])
            left = k > 0
            if np.count_nonzero(left) < WORTH_DROPPING * len(left):
                rows, k, a, w, rank, place = (part[left] for part in (rows, k, a, w, rank, place))

    @staticmethod
    def _place(table: StateTable, k: Array, a: Array, w: Array) -> Array:
        place: Array = table.start[k] + a * table.width[k] + w
        return place

    def _gather(self, tables: list[StateTable], k: Array, a: Array, w: Array) -> Array:
        """Return the exact number of solutions per state, or 0 for states outside the table."""
        reach = np.array(tables[0].shape.reach, dtype=np.int64)
        inside = (k >= 0) & (a >= 0) & (w >= 0)
        k = np.maximum(k, 0)
        inside &= (a <= reach[k, 0]) & (w <= reach[k, 1])
        place = np.where(inside, self._place(tables[0], k, a, w), 0)
        return self._whole([table.flat.take(place) * inside for table in tables])

    def _whole(self, residues: list[Array]) -> Array:
        """Return the counts that have the given residues, as 64-bit or Python integers."""
        if self.moduli == (WORD,):
            return residues[0]
        factors, whole = weights(self.moduli)
        parts = [r.astype(object) * f for r, f in zip(residues, factors, strict=True)]
        joined: Array = sum(parts[1:], parts[0]) % whole
        return joined

    def _number(self, value: int) -> object:
        return np.uint64(value) if self.moduli == (WORD,) else value


def _factors(ways: Ways, k: Array, copies: int, kind: np.dtype[Any]) -> Array:
    """For each k, return the number of ways to place `copies` equal values at k positions."""
    table = np.array([ways(number, copies) for number in range(int(k.max()) + 1)], dtype=kind)
    return table[k]
