"""Seeded orders that come out the same on every machine and in every version.

The random numbers are SHA-256 of a key and a counter, not a library's generator: NumPy and
``random`` keep their bit streams but not what ``shuffle`` makes of them. All orders are uniform
over what their rule admits.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from functools import cache
from statistics import NormalDist
from typing import TYPE_CHECKING, Literal, TypeVar

from faults import UserError

if TYPE_CHECKING:
    from collections.abc import Sequence

Item = TypeVar("Item")
Rule = Literal["simple", "blocked", "williams"]


class Stream:
    """Random numbers that depend on nothing but the key.

    Parameters
    ----------
    *key : str or int
        What the numbers are for: seed, participant, task, purpose. Different keys give
        independent streams.

    Examples
    --------
    >>> Stream(2007, "01", "order").below(4) == Stream(2007, "01", "order").below(4)
    True
    """

    def __init__(self, *key: str | int) -> None:
        # The separator cannot occur in a key's part, so no two keys run together.
        parts = [str(part).replace("\x1f", "\x1f\x1f") for part in key]
        self._key = "\x1f|".join(parts).encode()
        self._count = 0

    def bits(self) -> int:
        """Return the next 64 random bits."""
        block = hashlib.sha256(self._key + b"\x1f#" + str(self._count).encode()).digest()
        self._count += 1
        return int.from_bytes(block[:8], "big")

    def below(self, bound: int) -> int:
        """Return an integer uniform on 0 ... bound - 1, without modulo bias."""
        if not 0 < bound <= 1 << 64:
            raise ValueError(f"bound is {bound}, expected 1 to 2**64")
        limit = (1 << 64) - (1 << 64) % bound
        while True:
            drawn = self.bits()
            if drawn < limit:
                return drawn % bound

    def uniform(self) -> float:
        """Return a float uniform on the open interval (0, 1)."""
        return ((self.bits() >> 12) + 0.5) / (1 << 52)

    def normal(self) -> float:
        """Return a standard normal deviate (by inversion)."""
        return NormalDist().inv_cdf(self.uniform())

    def shuffled(self, items: Sequence[Item]) -> list[Item]:
        """Return the items in uniformly random order (Fisher and Yates)."""
        order = list(items)
        for last in range(len(order) - 1, 0, -1):
            other = self.below(last + 1)
            order[last], order[other] = order[other], order[last]
        return order

    def choice(self, items: Sequence[Item]) -> Item:
        """Return one of the items, each as likely."""
        return items[self.below(len(items))]


def williams_square(size: int) -> list[list[int]]:
    """Return orders of ``size`` conditions balanced for first-order carry-over.

    Every condition follows every other equally often, and stands in every position equally often:
    ``size`` rows for an even size, twice as many for an odd one (Williams 1949,
    doi:10.1071/CH9490149).

    Returns
    -------
    list of list of int
        Rows of 0 ... size - 1.
    """
    # 0, 1, n-1, 2, n-2, ...: neighbours differ by every amount once.
    first = [0, *((step + 1) // 2 if step % 2 else size - step // 2 for step in range(1, size))]
    square = [[(place + shift) % size for place in first] for shift in range(size)]
    return square if size % 2 == 0 else square + [row[::-1] for row in square]


@cache
def _arrangements(counts: tuple[int, ...], last: int) -> int:
    """Count the orders of a multiset without immediate repeats.

    ``counts`` are how many of each kind are left, sorted; ``last`` is how many are left of the
    kind that stood last (-1: nothing stood before), for kinds with equal counts are alike.
    """
    if not any(counts):
        return 1
    total = 0
    barred = last >= 0
    for count, kinds in Counter(counts).items():
        free = kinds - (1 if barred and count == last else 0)
        if count and free:
            left = list(counts)
            left[left.index(count)] -= 1
            total += free * _arrangements(tuple(sorted(left)), count - 1)
    return total


def without_repeats(items: Sequence[Item], stream: Stream) -> list[Item]:
    """Return the items in an order uniform over those in which no neighbours are equal.

    Raises
    ------
    UserError
        There is no such order.
    """
    kinds = list(dict.fromkeys(items))
    left = [items.count(kind) for kind in kinds]
    if not _arrangements(tuple(sorted(left)), -1):
        raise UserError(
            "no_immediate_repeat: one surface is presented so often that it must follow itself; "
            "use more surfaces or fewer repetitions of it"
        )
    order: list[Item] = []
    previous: int | None = None
    for _ in items:
        ways = []
        for kind, count in enumerate(left):
            rest = left.copy()
            rest[kind] -= 1
            allowed = count and kind != previous
            ways.append(_arrangements(tuple(sorted(rest)), rest[kind]) if allowed else 0)
        rank = _below_big(sum(ways), stream)
        kind = 0
        while rank >= ways[kind]:
            rank -= ways[kind]
            kind += 1
        left[kind] -= 1
        previous = kind
        order.append(kinds[kind])
    return order


def _below_big(bound: int, stream: Stream) -> int:
    """Return an integer uniform on 0 ... bound - 1 for a bound of any size."""
    size = bound.bit_length() + 64
    while True:
        drawn = 0
        for _ in range(-(-size // 64)):
            drawn = drawn << 64 | stream.bits()
        span = 1 << 64 * -(-size // 64)
        if drawn < span - span % bound:
            return drawn % bound


def presentation_order(
    conditions: int,
    repetitions: int,
    rule: Rule,
    *,
    stream: Stream,
    row: int,
    no_immediate_repeat: bool = False,
) -> list[list[int]]:
    """Return the order in which conditions are presented.

    Parameters
    ----------
    conditions : int
        How many surfaces; they are numbered 0 ... conditions - 1.
    repetitions : int
        How often each is presented.
    rule : {"simple", "blocked", "williams"}
        All shuffled together; each once a block, shuffled within; or each block a row of a
        Williams square, so that carry-over is balanced across blocks and participants.
    stream : Stream
        The participant's own random numbers.
    row : int
        The participant's place in the counterbalancing (0, 1, ...), for "williams".
    no_immediate_repeat : bool
        No surface follows itself, across the limits of blocks neither.

    Returns
    -------
    list of list of int
        Blocks of conditions; "simple" is one block.
    """
    everything = list(range(conditions))
    if rule == "simple":
        pool = everything * repetitions
        return [without_repeats(pool, stream) if no_immediate_repeat else stream.shuffled(pool)]
    square = williams_square(conditions)
    blocks: list[list[int]] = []
    for block in range(repetitions):
        # Neighbouring participants take neighbouring rows, and so do a participant's own blocks.
        order = (
            square[(row * repetitions + block) % len(square)]
            if rule == "williams"
            else stream.shuffled(everything)
        )
        clash = no_immediate_repeat and blocks and blocks[-1][-1] == order[0]
        if clash and conditions == 1:
            raise UserError("no_immediate_repeat: one surface alone must follow itself")
        while clash and blocks[-1][-1] == order[0]:
            order = stream.choice(square) if rule == "williams" else stream.shuffled(everything)
        blocks.append(list(order))
    return blocks


def with_catch_steps(
    amplitudes: Sequence[float], catch_steps: int, stream: Stream
) -> list[tuple[float, float]]:
    """Return the steps of a descending series as (before, after), catch steps shuffled in.

    A catch step changes nothing: before and after are equal. It may come at any place, also
    first or last; every choice of places is equally likely.

    >>> with_catch_steps([2.3, 1.2, 0.5], 0, Stream(1))
    [(2.3, 1.2), (1.2, 0.5)]
    """
    real = len(amplitudes) - 1
    marks = stream.shuffled([False] * real + [True] * catch_steps)
    steps: list[tuple[float, float]] = []
    at = 0
    for catch in marks:
        after = at if catch else at + 1
        steps.append((amplitudes[at], amplitudes[after]))
        at = after
    return steps
