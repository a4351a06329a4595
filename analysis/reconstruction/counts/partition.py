"""Partition a column's solutions into parts that depend only on n, sum and sum of squares.

A published minimum, maximum or median requires certain ratings to be present. In each part, some
ratings are fixed. The remaining ratings are free: they may take any permitted value in one interval
or, if the median is published, in two intervals below and above the median. Every consistent
multiset or ordered sample belongs to exactly one part.

- Multisets: each required rating is fixed once, and further occurrences are free. If the median is
  published, the smaller half of the free ratings is at most the lower middle rating, and the larger
  half is at least the upper one. There is one part per pair of middle ratings.
- Ordered samples: the number of orders depends on how often a rating occurs. There is one part for
  each combination of frequencies of the required ratings, which are then not free.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product
from math import comb, prod


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

    def most_copies(self, value: int) -> int:
        """Return an upper bound on the number of occurrences of `value`.

        If c of the n values are equal to x, the squared deviations from the mean m add up to at
        least c (x - m)² n / (n - c).
        """
        spread, far = self.n * self.squares - self.total**2, (self.n * value - self.total) ** 2
        if self.n <= 0 or spread < 0:
            return 0
        return self.n * spread // (spread + far) if spread + far else self.n

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

    Distances are measured from `centre`, with ``below <= centre <= above``. The intervals share at
    most one value, the centre. The values in `holes` are excluded.
    """

    low: int
    below: int
    centre: int
    above: int
    high: int
    holes: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Part:
    """All solutions that consist of the same fixed values and any permitted free values.

    All solutions in a part have the same number, sum and sum of squares of free values.

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


def partition(every: Iterable[Wanted], measure: str = "multisets") -> Iterator[Part]:
    """Yield disjoint parts that together contain all solutions."""
    once = measure == "multisets"
    known: dict[tuple[Split, Given, int], list[_Middle]] = {}
    for wanted in every:
        fixed = _fixed(wanted, once)
        for moments, low, high, given in _ends(wanted, fixed, once):
            holes = frozenset(value for value in fixed if low <= value <= high)
            # Any centre gives correct results; with the mean, tables are small.
            centre = round(moments.total / max(moments.n, 1))
            if wanted.medians is None:
                centre = min(max(centre, low), max(low, high))
                split = Split(low, centre - 1, centre, centre, high, holes)
                yield Part(split, moments, given, 0, moments.n)
                continue
            for lower, upper in wanted.medians:
                split = Split(low, lower, centre, upper, high, holes)
                key = split, given, moments.n
                if key not in known:
                    known[key] = list(_around(*key, once))
                yield from (part for middle in known[key] if (part := middle.part(moments, given)))


def most_parts(wanted: Wanted, measure: str) -> int:
    """Return an upper bound on the number of parts that `partition` has to examine."""
    n, once = wanted.moments.n, measure == "multisets"
    fixed = _fixed(wanted, once)
    number = prod(most - least + 1 for v, least, most in wanted.occurrences if v in fixed)
    if once:
        number *= prod(map(len, wanted.present))
        return number * (1 if wanted.medians is None else len(wanted.medians))
    required = frozenset[int]().union(*wanted.present) - fixed
    number *= prod(1 + wanted.moments.most_copies(value) for value in required)
    # All frequencies together add up to at most n.
    values = len(required | fixed)
    if wanted.medians is None:
        return min(number, comb(n + values, n))
    return sum(
        min(number * (n // 2) ** 2, comb(n + values + 2, n))
        if lower < upper
        else min(number * n, comb(n + values + 1, n))
        for lower, upper in wanted.medians
    )


def _fixed(wanted: Wanted, once: bool) -> frozenset[int]:
    """Return the values that are never free, because their number of occurrences is restricted."""
    return frozenset(
        value for value, _, most in wanted.occurrences if not once or most < wanted.moments.n
    )


def _ends(
    wanted: Wanted, fixed: frozenset[int], once: bool
) -> Iterator[tuple[Moments, int, int, Given]]:
    """Yield the free values' moments, minimum and maximum, and the fixed values."""
    choices = (
        range(least, (most if value in fixed else least) + 1)
        for value, least, most in wanted.occurrences
    )
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
        yield from _enter(moments, wanted.low, wanted.high, present, given, fixed, once)


def _enter(  # noqa: PLR0917 - one argument for each thing that a part is made of
    moments: Moments,
    low: int,
    high: int,
    present: tuple[frozenset[int], ...],
    given: Given,
    fixed: frozenset[int],
    once: bool,
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
    most = moments.most_copies(value)
    for times in range((min(most, 1) if once else most) + 1):
        rest = moments.without(value, times)
        wishes = (
            tuple(wish for wish in present if value not in wish)
            if times
            else tuple(wish - {value} for wish in present)
        )
        more = (*given, (value, times)) if times else given
        ends = (low, high) if times and once else inside
        yield from _enter(rest, *ends, wishes, more, fixed, once)


@dataclass(frozen=True)
class _Middle:
    """The fixed values among the middle ratings, and the free values below and above them."""

    split: Split
    given: Given
    fewest_below: int
    most_below: int

    def part(self, moments: Moments, given: Given) -> Part | None:
        """Return the part with these middle ratings, or None if they are impossible.

        `moments` are those of all values except `given`.
        """
        for value, times in self.given:
            moments = moments.without(value, times)
        if moments.squares < 0:
            return None
        every = (*given, *self.given)
        return Part(self.split, moments, every, self.fewest_below, self.most_below)


def _around(free: Split, given: Given, number: int, once: bool) -> Iterator[_Middle]:
    """Yield the middle ratings' possible frequencies if they are ``free.below`` and ``free.above``.

    The middle ratings of a sorted data set determine its median. Multisets have at most one part:
    each half of a sorted multiset consists of values up to the lower middle rating or of values
    from the upper one. In each part of ordered samples, the frequencies of the middle ratings are
    fixed.

    Parameters
    ----------
    free : Split
        Middle ratings, minimum and maximum of the free values, and their mean as the centre.
    given : tuple of (int, int)
        Fixed values other than middle ratings, each with its number of occurrences.
    number : int
        Number of other values.
    once : bool
        Whether to fix each middle rating only as often as necessary.
    """
    low, lower, upper, high = free.low, free.below, free.above, free.high
    n = number + sum(times for _, times in given)
    half = (n - 1) // 2
    below = sum(times for value, times in given if value < lower)
    above = sum(times for value, times in given if value > upper)
    held = {lower: 0, upper: 0} | {v: t for v, t in given if v in (lower, upper)}
    if below + above + sum(held.values()) < n - number:
        return  # No value can lie between the two middle ratings.
    # Unless the two middle ratings differ, the same rating is needed once or, if n is even, twice.
    needed = 1 if lower < upper else n - 2 * half
    # Further fixed copies of the only middle rating may be below or above it, so none can be free.
    once = once and (lower < upper or held[lower] <= needed)
    if once:
        centre = min(max(free.centre, lower + 1), upper)
        split = Split(low, min(lower, high), centre, max(upper, low), high, free.holes)
    else:
        split = Split(low, min(lower - 1, high), lower, max(upper + 1, low), high, free.holes)
    are_free = [low <= value <= high and value not in free.holes for value in held]
    most = half + 1 if lower < upper else number
    choices = []
    for times, is_free in zip(held.values(), are_free, strict=True):
        least = max(needed - times, 0) if is_free else 0
        choices.append(range(least, (most if is_free and not once else least) + 1))
    for copies in product(*choices):
        rest = number - sum(copies)
        if lower < upper:
            at = [have + more for have, more in zip(held.values(), copies, strict=True)]
            fewest_below = most_below = half + 1 - below - at[0] if all(at) else -1
        elif once and are_free[0]:
            fewest_below = most_below = half - below
        else:
            fewest_below, most_below = rest - (half - above), half - below
        fewest_below, most_below = max(fewest_below, 0), min(most_below, rest)
        if fewest_below <= most_below:
            more = tuple((v, times) for v, times in zip(held, copies, strict=True) if times)
            yield _Middle(split, more, fewest_below, most_below)
