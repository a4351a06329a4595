"""Random orders without immediate repetitions; all such orders are equally likely.

An order without equal neighbours is known as a Smirnov word. Smirnov words are counted by
inclusion-exclusion over blocks of equal items (Flajolet and Sedgewick, Analytic Combinatorics,
2009, Example III.24), in exact integers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import chain, pairwise

from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.faults import UserError

ALONE = (
    "no_immediate_repeat: a single surface always follows itself; use more surfaces, or "
    "no_immediate_repeat = false"
)
# 1200 trials take four hours, and generating their order takes a second.
MOST = 1200


def without_repeats(kinds: int, each: int, stream: Stream) -> list[int]:
    """Return a random order of 0 to ``kinds - 1``, each ``each`` times, without equal neighbours.

    The order begins as the copies of 0. The copies of each further number are divided into groups,
    which are inserted into the order. Each group is inserted either between two equal neighbours or
    at another position. The numbers of groups at these two types of position are chosen at random,
    with probabilities proportional to the exact number of orders that result from each choice. All
    other choices are uniform shuffles. Once the counts are cached, the running time is
    linear in the number of copies.

    Raises
    ------
    UserError
        If there is only one kind, or so many copies that generating the order would take more than
        a second.
    """
    if kinds == 1 and each > 1:
        raise UserError(ALONE)
    if kinds * each > MOST:
        raise UserError(
            "{kinds} trials are too many for an order without immediate repeats; at most {most} "
            'can be drawn with randomisation = "simple"; use "blocked", or fewer repetitions',
            kinds=kinds * each,
            most=MOST,
        )
    counts = _counts(each, kinds)
    order = [0] * each
    for kind in range(1, kinds):
        parted = [place for place in range(1, len(order)) if order[place - 1] == order[place]]
        others = sorted(set(range(len(order) + 1)) - set(parted))
        inside, outside = counts.draw_groups(kind, len(parted), stream)
        chosen = {*_some(parted, inside, stream), *_some(others, outside, stream)}
        cuts = _some(range(1, each), inside + outside - 1, stream)
        sizes = iter([end - start for start, end in pairwise([0, *cuts, each])])
        longer: list[int] = []
        for place in range(len(order) + 1):
            longer += [kind] * next(sizes) if place in chosen else []
            longer += order[place : place + 1]
        order = longer
    return order


def _some(items: Sequence[int], number: int, stream: Stream) -> list[int]:
    """Select ``number`` items with equal probability, and keep their order."""
    marks = stream.shuffled([True] * number + [False] * (len(items) - number))
    return [item for item, mark in zip(items, marks, strict=True) if mark]


@cache
def _counts(each: int, kinds: int) -> _Counts:
    return _Counts(each, kinds)


@dataclass(slots=True)
class _Counts:
    """Number of ways to complete an unfinished order so that no neighbours are equal."""

    each: int
    kinds: int
    _signed: list[list[int]] = field(init=False)
    _known: dict[tuple[int, int], int] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self._signed = _signed_blocks(self.each, self.kinds - 1)

    def completions(self, placed: int, equal: int) -> int:
        """Return the number of ways to insert the missing items so that no neighbours are equal.

        Parameters
        ----------
        placed : int
            Number of kinds of items that are already in the order.
        equal : int
            Number of pairs of equal neighbours in the unfinished order.
        """
        if (placed, equal) not in self._known:
            # Every equal pair must be separated by a block of another kind. The remaining blocks
            # can be at any position, so there are C(items + blocks - equal, blocks - equal) ways.
            signed = self._signed[self.kinds - placed]
            total, ways = 0, 1
            for blocks in range(equal, len(signed)):
                total += ways * signed[blocks]
                more = blocks + 1 - equal
                ways = ways * (placed * self.each + more) // more
            self._known[placed, equal] = total
        return self._known[placed, equal]

    def draw_groups(self, placed: int, equal: int, stream: Stream) -> tuple[int, int]:
        """Choose at random into how many groups the copies of the next number are divided.

        Return the number of groups to insert between equal neighbours, and the number of groups to
        insert at other positions.
        """
        each, items = self.each, placed * self.each

        @cache
        def ways(choice: tuple[int, int]) -> int:
            inside, outside = choice
            if not (0 <= inside <= equal and outside >= 0 and 1 <= inside + outside <= each):
                return 0
            return (
                math.comb(equal, inside)
                * math.comb(items + 1 - equal, outside)
                * math.comb(each - 1, inside + outside - 1)
                * self.completions(placed + 1, equal + each - 2 * inside - outside)
            )

        rank = stream.below_any(self.completions(placed, equal))
        # Choices can be tried in any order without changing the distribution. Starting with the
        # most likely choice is fastest.
        best = (min(equal, each), max(each - equal, 0))
        while ways(near := max(_ring(best, 1), key=ways)) > ways(best):
            best = near
        for choice in chain.from_iterable(_ring(best, n) for n in range(max(equal, each) + 1)):
            if rank < ways(choice):
                return choice
            rank -= ways(choice)
        raise RuntimeError("the counts of orders do not add up")


def _ring(centre: tuple[int, int], distance: int) -> list[tuple[int, int]]:
    """Return the grid points at a given Chebyshev distance from the centre."""
    span = range(-distance, distance + 1)
    column, row = centre
    return [(column + x, row + y) for x in span for y in span if max(abs(x), abs(y)) == distance]


def _signed_blocks(each: int, most: int) -> list[list[int]]:
    """Return the signed counts of orders that inclusion-exclusion adds up.

    Element ``[kinds][blocks]`` is the number of sequences of ``blocks`` blocks of equal items in
    which each of ``kinds`` kinds has ``each`` copies, for 0 to ``most`` kinds. The number is
    negative if the number of items minus the number of blocks is odd. In the sum, orders with equal
    neighbours therefore cancel.
    """
    scale = math.factorial(each)
    # Terms of the exponential generating function for one kind, scaled to integers.
    one = [
        (-1) ** (each - blocks)
        * math.comb(each - 1, blocks - 1)
        * (scale // math.factorial(blocks))
        for blocks in range(1, each + 1)
    ]
    products = [[1]]
    for _ in range(most):
        longer = [0] * (len(products[-1]) + each)
        for place, factor in enumerate(products[-1]):
            if factor:
                for blocks, value in enumerate(one, start=place + 1):
                    longer[blocks] += factor * value
        products.append(longer)
    return [
        [math.factorial(blocks) * value // scale**kinds for blocks, value in enumerate(product)]
        for kinds, product in enumerate(products)
    ]
