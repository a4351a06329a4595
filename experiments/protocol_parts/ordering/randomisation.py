"""Seeded random numbers that are the same on every machine and in every version.

The numbers are SHA-256 hashes of a key and a counter. NumPy and ``random`` are not used, because
their ``shuffle`` can give different results in different versions.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from statistics import NormalDist
from typing import TypeVar

from slipscale.faults.message import Message

Item = TypeVar("Item")


class Stream:
    """A stream of random numbers that depends only on its key.

    Parameters
    ----------
    *key : str or int
        Parts of the key, such as seed, participant and task. Different keys give
        independent streams.

    Examples
    --------
    >>> Stream(2007, "01", "order").below(4) == Stream(2007, "01", "order").below(4)
    True
    """

    def __init__(self, *key: str | int) -> None:
        # The separator cannot occur in a part of a key, so different keys stay different.
        parts = [str(part).replace("\x1f", "\x1f\x1f") for part in key]
        self._key = "\x1f|".join(parts).encode()
        self._count = 0

    def bits(self) -> int:
        """Return the next 64 random bits."""
        block = hashlib.sha256(self._key + b"\x1f#" + str(self._count).encode()).digest()
        self._count += 1
        return int.from_bytes(block[:8], "big")

    def below(self, bound: int) -> int:
        """Return a random integer, uniform on 0 ... bound - 1, without modulo bias."""
        if not 0 < bound <= 1 << 64:
            raise ValueError(Message("bound is {bound}, expected 1 to 2**64", bound=bound))
        limit = (1 << 64) - (1 << 64) % bound
        while True:
            drawn = self.bits()
            if drawn < limit:
                return drawn % bound

    def below_any(self, bound: int) -> int:
        """Return a random integer, uniform on 0 ... bound - 1, for a bound of any size."""
        words = -(-(bound.bit_length() + 64) // 64)
        span = 1 << 64 * words
        while True:
            drawn = 0
            for _ in range(words):
                drawn = drawn << 64 | self.bits()
            if drawn < span - span % bound:
                return drawn % bound

    def uniform(self) -> float:
        """Return a random float, uniform on the open interval (0, 1)."""
        return ((self.bits() >> 12) + 0.5) / (1 << 52)

    def normal(self) -> float:
        """Return a standard normal deviate (by inversion)."""
        return NormalDist().inv_cdf(self.uniform())

    def shuffled(self, items: Sequence[Item]) -> list[Item]:
        """Return the items in uniformly random order (Fisher–Yates shuffle)."""
        order = list(items)
        for last in range(len(order) - 1, 0, -1):
            other = self.below(last + 1)
            order[last], order[other] = order[other], order[last]
        return order

    def choice(self, items: Sequence[Item]) -> Item:
        """Return a random item; all items are equally likely."""
        return items[self.below(len(items))]


def with_catch_steps(
    amplitudes: Sequence[float], catch_steps: int, stream: Stream
) -> list[tuple[float, float]]:
    """Return the steps of a descending series as (before, after) pairs, with catch steps.

    In a catch step, the amplitude does not change. Catch steps may occur anywhere, including first
    and last, and all placements are equally likely.

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
