"""Partition a column's solutions into parts that depend only on n, sum and sum of squares.

A published minimum, maximum or median requires certain ratings to be present. The solutions are
partitioned by how often each required rating occurs. Within a part, the frequencies of the required
ratings are fixed. The remaining ratings are free: they may take any permitted value in one interval
or, if the median is published, in two intervals below and above the median. Every consistent
multiset or ordered sample belongs to exactly one part.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import comb


@dataclass(frozen=True)
class Moments:
    """The count, sum and sum of squares that a set of values must have."""

    n: int
    total: int
    squares: int

    def without(self, value: int, times: int) -> Moments:
        """Return the moments without `times` occurrences of `value`."""
        return Moments(
            self.n - times, self.total - times * value, self.squares - times * value * value
        )

    def possible(self, low: int, high: int) -> bool:
        """Return whether values in [low, high] could have these moments."""
        if self.n == 0:
            return self.total == 0 and self.squares == 0
        if self.n < 0 or low > high or not self.n * low <= self.total <= self.n * high:
            return False
        # (x - low)(x - high) <= 0 for every value.
        most = (low + high) * self.total - self.n * low * high
        return self.total**2 <= self.n * self.squares and self.squares <= most


@dataclass(frozen=True)
class Wanted:
    """The requirements that a column's ratings must meet.

    Ratings are given as numbers of scale steps above the minimum of the scale.

    Parameters
    ----------
    moments : Moments
        Number, sum and sum of squares of all ratings.
    low, high : int
        Smallest and largest permitted rating.
    present : tuple of frozenset of int
        Sets of consecutive ratings at the lower or upper end of the range. At least one rating from
        each set must be present.
    medians : tuple of (int, int), optional
        Permitted pairs of the two middle ratings of the sorted data set (the same rating twice if n
        is odd).
    occurrences : tuple of (int, int, int)
        Ratings, each with its minimum and maximum number of occurrences.
    """

    moments: Moments
    low: int
    high: int
    present: tuple[frozenset[int], ...] = ()
    medians: tuple[tuple[int, int], ...] | None = None
    occurrences: tuple[tuple[int, int, int], ...] = ()


@dataclass(frozen=True)
class Split:
    """The two intervals in which the free values lie: [low, below] and [above, high].

    Distances are measured from `centre`, with ``below < centre <= above``. The values in `holes`
    are excluded.
    """

    low: int
    below: int
    centre: int
    above: int
    high: int
    holes: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Part:
    """All solutions that contain the same fixed values with the same frequencies.

    The remaining values of a solution are called free values. All solutions in a part have the same
    number, sum and sum of squares of free values.

    Parameters
    ----------
    split : Split
        Intervals that contain the free values.
    moments : Moments
        Number, sum and sum of squares of the free values.
    given : tuple of (int, int)
        Fixed values, each with its number of occurrences.
    fewest_below, most_below : int
        Minimum and maximum number of free values in the lower interval.
    """

    split: Split
    moments: Moments
    given: tuple[tuple[int, int], ...]
    fewest_below: int
    most_below: int

    @property
    def all_moments(self) -> tuple[int, int]:
        """Sum and sum of squares of all values, both fixed and free."""
        given = [value for value, times in self.given for _ in range(times)]
        return (
            self.moments.total + sum(given),
            self.moments.squares + sum(value**2 for value in given),
        )

    @property
    def arrangements(self) -> int:
        """Number of ways to choose the positions of the fixed values in an ordered sample."""
        ways, n = 1, self.moments.n
        for _, times in self.given:
            n += times
            ways *= comb(n, times)
        return ways


Given = tuple[tuple[int, int], ...]


def partition(wanted: Wanted) -> Iterator[Part]:
    """Yield disjoint parts that together contain all solutions."""
    if wanted.medians is None:
        for moments, low, high, given in _ends(wanted):
            # Any centre gives correct results; with the mean, tables are small.
            centre = min(max(round(moments.total / max(moments.n, 1)), low), max(low, high))
            split = Split(low, centre - 1, centre, centre, high, _holes(wanted, low, high))
            yield Part(split, moments, given, 0, moments.n)
        return
    for lower, upper in wanted.medians:
        yield from _around(wanted, lower, upper)


def _holes(wanted: Wanted, low: int, high: int) -> frozenset[int]:
    """Return the values from `low` to `high` whose number of occurrences is restricted."""
    return frozenset(value for value, _, _ in wanted.occurrences if low <= value <= high)


def _ends(wanted: Wanted) -> Iterator[tuple[Moments, int, int, Given]]:
    """Yield the free values' moments, minimum and maximum, and the fixed values."""
    if not wanted.occurrences:
        yield from _enter(wanted.moments, wanted.low, wanted.high, wanted.present, (), frozenset())
        return
    fixed = frozenset(value for value, _, _ in wanted.occurrences)
    choices = (range(least, most + 1) for _, least, most in wanted.occurrences)
    for numbers in product(*choices):
        moments = wanted.moments
        given: Given = ()
        for (value, _, _), times in zip(wanted.occurrences, numbers, strict=True):
            moments = moments.without(value, times)
            given = (*given, (value, times)) if times else given
        if moments.n < 0 or moments.squares < 0:
            continue
        values = {value for value, _ in given}
        if any(not wanted.low <= value <= wanted.high for value in values):
            continue
        present = tuple(wish - fixed for wish in wanted.present if not wish & values)
        yield from _enter(moments, wanted.low, wanted.high, present, given, fixed)


def _enter(  # noqa: PLR0917 - one argument for each thing that a part is made of
    moments: Moments,
    low: int,
    high: int,
    present: tuple[frozenset[int], ...],
    given: Given,
    fixed: frozenset[int],
) -> Iterator[tuple[Moments, int, int, Given]]:
    while fixed and low <= high and low in fixed:
        low += 1
    while fixed and low <= high and high in fixed:
        high -= 1
    if not present:
        if moments.possible(low, high):
            yield moments, low, high, given
        return
    if low > high or any(not wish for wish in present):
        return
    at_low = any(low in wish for wish in present)
    value = low if at_low else high
    inside = (low + 1, high) if at_low else (low, high - 1)
    for times in range(moments.n + 1):
        rest = moments.without(value, times)
        if rest.squares < 0 and times:
            return
        wishes = (
            tuple(wish for wish in present if value not in wish)
            if times
            else tuple(wish - {value} for wish in present)
        )
        more = (*given, (value, times)) if times else given
        yield from _enter(rest, *inside, wishes, more, fixed)


def _around(wanted: Wanted, lower: int, upper: int) -> Iterator[Part]:
    """Yield the parts of the solutions in which the two middle ratings are `lower` and `upper`.

    The middle ratings of a sorted data set determine its median. In each part, the frequencies of
    the middle ratings are fixed.
    """
    for moments, low, high, given in _ends(wanted):
        holes = _holes(wanted, low, high)
        split = Split(low, min(lower - 1, high), lower, max(upper + 1, low), high, holes)
        below = sum(times for value, times in given if value < lower)
        above = sum(times for value, times in given if value > upper)
        middle = {lower: 0, upper: 0} | {v: t for v, t in given if v in (lower, upper)}
        if below + above + sum(middle.values()) < wanted.moments.n - moments.n:
            continue  # No value can lie between the two middle ratings.
        for copies in _copies(middle, moments.n, low, high, holes):
            rest, more = moments, given
            for value, times in copies:
                rest = rest.without(value, times)
                more = (*more, (value, times)) if times else more
            if rest.n < 0 or rest.squares < 0:
                continue
            if lower == upper:
                most = (wanted.moments.n - 1) // 2
                fewest_below, most_below = rest.n - (most - above), most - below
            else:
                half = wanted.moments.n // 2
                at = {value: middle[value] + times for value, times in copies}
                if not all(at.values()):
                    continue
                most_below = fewest_below = half - below - at[lower]
            fewest_below, most_below = max(fewest_below, 0), min(most_below, rest.n)
            if fewest_below <= most_below:
                yield Part(split, rest, more, fewest_below, most_below)


def _copies(
    middle: dict[int, int], n: int, low: int, high: int, holes: frozenset[int]
) -> Iterator[Given]:
    """Yield the possible additional frequencies of the middle ratings.

    The additional frequency is 0 for a rating that is already fixed, is excluded or is out of
    range.
    """
    ranges = [
        range(n + 1) if low <= value <= high and not held and value not in holes else range(1)
        for value, held in middle.items()
    ]
    for times in product(*ranges):
        yield tuple(zip(middle, times, strict=True))
