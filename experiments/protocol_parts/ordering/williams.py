"""Williams designs: orders in which every surface follows every other surface equally often.

A design consists of complete Williams squares, whose rows are divided among a group of runs. The
labels of the conditions and the order of the rows are random; the balance is exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

from slipscale.experiments.protocol_parts.ordering.randomisation import Stream


def williams_square(size: int) -> list[list[int]]:
    """Return orders of ``size`` conditions that are balanced for first-order carry-over.

    Every condition follows every other condition equally often, and occurs in every position
    equally often. The square has ``size`` rows if the size is even, and twice as many if it is odd
    (Williams 1949, doi:10.1071/CH9490149).

    Returns
    -------
    list of list of int
        Rows of the square, each an order of the conditions 0 to ``size - 1``.
    """
    # 0, 1, n-1, 2, n-2, ...: neighbours differ by every amount once.
    first = [0, *((step + 1) // 2 if step % 2 else size - step // 2 for step in range(1, size))]
    square = [[(place + shift) % size for place in first] for shift in range(size)]
    return square if size % 2 == 0 else square + [row[::-1] for row in square]


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """A run's position in the counterbalancing across participants and visits.

    Parameters
    ----------
    row : int
        The participant's position: 0, 1, ...
    visit : int
        Index of the run among the participant's runs: 0, 1, ...
    advance : bool
        Whether each run of a participant takes the next position. If False, all runs of a
        participant have the same position.
    """

    row: int
    visit: int = 0
    advance: bool = True

    def within(self, size: int) -> tuple[int, int, int]:
        """Return the numbers of the run's group, turn and position.

        A group consists of ``size`` participants, and each turn of a group has its own random
        design with ``size`` positions. If ``advance`` is True, a turn consists of ``size`` runs per
        participant, in which the participant takes each position once. If False, the turn
        increases with each run of a participant, and the position stays the same.
        """
        group, place = divmod(self.row, size)
        turn, step = divmod(self.visit, size) if self.advance else (self.visit, 0)
        return group, turn, (place + step) % size


def williams_group(conditions: int, repetitions: int, *, no_immediate_repeat: bool) -> int:
    """Return the smallest number of runs that together use complete Williams squares."""
    rows = len(williams_square(conditions))
    return rows // math.gcd(rows, _rows_drawn(conditions, repetitions, no_immediate_repeat))


def _rows_drawn(conditions: int, repetitions: int, no_immediate_repeat: bool) -> int:
    """Return how many rows of Williams squares a run uses."""
    # Without immediate repeats, two conditions alternate, so the first block determines the rest.
    return 1 if no_immediate_repeat and conditions == 2 else repetitions  # noqa: PLR2004 - said above


def williams_blocks(
    conditions: int,
    repetitions: int,
    shared: Callable[[int, int], Stream],
    place: Place,
    no_immediate_repeat: bool,
) -> list[list[int]]:
    """Return a run's blocks, which are rows of the Williams squares shared by a group of runs.

    Each square has new random labels and a new random order of its rows. A run's blocks are
    successive rows. The last row of a square is followed by the first row of the next square.
    """
    taken = _rows_drawn(conditions, repetitions, no_immediate_repeat)
    size = williams_group(conditions, repetitions, no_immediate_repeat=no_immediate_repeat)
    group, turn, own = place.within(size)
    stream = shared(group, turn)
    square = williams_square(conditions)
    blocks: list[list[int]] = []

    def clash(rows: list[list[int]]) -> bool:
        known = blocks[-1:]
        return no_immediate_repeat and any(
            before[-1] == after[0]
            for number, (before, after) in enumerate(
                pairwise([*known, *rows]), start=len(blocks) + 1 - len(known)
            )
            if number % taken  # otherwise, `after` is the first block of another run
        )

    while len(blocks) < (own + 1) * taken:
        while True:
            labels = stream.shuffled(range(conditions))
            rows = [[labels[each] for each in row] for row in stream.shuffled(square)]
            if not clash(rows):
                break
        blocks += rows
    own_blocks = blocks[own * taken : (own + 1) * taken]
    return own_blocks * (repetitions // taken)
