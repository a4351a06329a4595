"""Orders in which nothing follows itself, drawn uniformly from all there are.

An order of several copies of each kind without equal neighbours is known as a Smirnov word. They
are counted by inclusion and exclusion over blocks of equal items (Flajolet and Sedgewick, Analytic
Combinatorics, 2009, Example III.24), in whole numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cache
from itertools import chain, pairwise
from typing import TYPE_CHECKING

from slipscale.faults import UserError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.experiments.protocols.ordering.randomisation import Stream

ALONE = (
    "no_immediate_repeat: one surface alone must follow itself; "
    "use more surfaces, or no_immediate_repeat = false"
)
# Four hours of trials; drawing one order takes a second.
MOST = 1200


def without_repeats(kinds: int, each: int, stream: Stream) -> list[int]:
    """Return ``each`` copies of 0 ... kinds - 1, uniform over all orders without equal neighbours.

    The kinds are put in one after the other: a kind's copies, cut into groups, part equal
    neighbours and go to other places too. How many groups go where is drawn with the exact number
    of orders that each choice leads to; the rest are shuffles. With the counts at hand (they are
    kept from one draw to the next) the time is linear in the number of copies.

    Raises
    ------
    UserError
        There is no such order: a single kind must follow itself. Or there are more copies than can
        be drawn in a second: the counts are exact, and their digits grow with the copies.
    """
    if kinds == 1 and each > 1:
        raise UserError(ALONE)
    if kinds * each > MOST:
        raise UserError(
            f"{kinds * each} trials in an order without immediate repeats: at most {MOST} can be "
            'drawn with randomisation = "simple"; use "blocked", or fewer repetitions'
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
    """Return so many of the items, every choice as likely, in their order."""
    marks = stream.shuffled([True] * number + [False] * (len(items) - number))
    return [item for item, mark in zip(items, marks, strict=True) if mark]


@cache
def _counts(each: int, kinds: int) -> _Counts:
    return _Counts(each, kinds)


@dataclass(slots=True)
class _Counts:
    """How many orders without equal neighbours an order of the first few kinds can become."""

    each: int
    kinds: int
    _signed: list[list[int]] = field(init=False)
    _known: dict[tuple[int, int], int] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self._signed = _signed_blocks(self.each, self.kinds - 1)

    def completions(self, placed: int, equal: int) -> int:
        """Count the ways to put the kinds in that are still to come.

        Parameters
        ----------
        placed : int
            How many kinds stand in the order already.
        equal : int
            How many pairs of neighbours in it are equal.
        """
        if (placed, equal) not in self._known:
            # Blocks of the other kinds go between the items: C(items + blocks - equal,
            # blocks - equal) ways, for every equal pair must have one.
            signed = self._signed[self.kinds - placed]
            total, ways = 0, 1
            for blocks in range(equal, len(signed)):
                total += ways * signed[blocks]
                more = blocks + 1 - equal
                ways = ways * (placed * self.each + more) // more
            self._known[placed, equal] = total
        return self._known[placed, equal]

    def draw_groups(self, placed: int, equal: int, stream: Stream) -> tuple[int, int]:
        """Draw how many groups of the next kind part equal neighbours, and how many do not."""
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
        # Any order of the choices gives the same distribution; the likeliest first ends soonest.
        best = (min(equal, each), max(each - equal, 0))
        while ways(near := max(_ring(best, 1), key=ways)) > ways(best):
            best = near
        for choice in chain.from_iterable(_ring(best, n) for n in range(max(equal, each) + 1)):
            if rank < ways(choice):
                return choice
            rank -= ways(choice)
        raise RuntimeError("the counts of orders do not add up")


def _ring(centre: tuple[int, int], distance: int) -> list[tuple[int, int]]:
    """Return the points of a grid whose larger difference from the centre is the distance."""
    span = range(-distance, distance + 1)
    column, row = centre
    return [(column + x, row + y) for x in span for y in span if max(abs(x), abs(y)) == distance]


def _signed_blocks(each: int, most: int) -> list[list[int]]:
    """Return the orders of blocks of equal items, signed, for 0 ... ``most`` kinds.

    By the number of blocks: each item beyond the first of its block turns the sign, so that by
    inclusion and exclusion all orders with equal neighbours cancel.
    """
    scale = math.factorial(each)
    # One kind's blocks, over the factorial of their number and times the scale: a whole number.
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
