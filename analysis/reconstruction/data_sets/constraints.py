"""Derive constraints on ratings from published numbers, including GRIM and GRIMMER.

Ratings are given as numbers of scale steps above the minimum of the scale, so their sums and sums
of squares are whole numbers. GRIM (Brown and Heathers, 2017) checks whether n whole numbers can
have the published mean. GRIMMER (Anaya, 2016; Allard, 2018) checks whether any sum of squares that
is a whole number of the right parity gives the published standard deviation. A column can pass both
tests although no data set is consistent with it, so only a count of the data sets is conclusive.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import isqrt
from typing import TYPE_CHECKING

from slipscale.analysis.published.printed_numbers import Interval
from slipscale.analysis.reconstruction.counts.partition import Moments, Wanted
from slipscale.analysis.reconstruction.table.contradictions import impossible, occurrences

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.table.published_table import Column


# Maximum number of pairs of sum and sum of squares that are listed.
MOST_PAIRS = 100_000
# Maximum number of sums for which `plain_sums` lists the sums of squares.
MOST_SUMS = 1000
# If there are more than `MOST_PAIRS` pairs, only this number of sums is used, each with the middle
# one of its possible sums of squares.
LOOKED_AT = 9
# Maximum number of candidates for extreme or middle ratings, in total over all pairs of sum and sum
# of squares. More would need gigabytes of memory.
MOST_VALUES = 3_000_000


@dataclass(frozen=True)
class Targets:
    """The requirements that a column's ratings must meet.

    Parameters
    ----------
    wanted : tuple of Wanted
        One entry per possible pair of sum and sum of squares of the ratings.
    grim : bool
        Whether any sum of ratings gives the published mean.
    grimmer : bool
        Whether any possible sum and sum of squares give the published standard deviation.
    reason : str
        Reason why no ratings can meet the requirements. Empty if no contradiction was found.
    refused : str
        Error message if there are too many requirements to list in `wanted`, otherwise empty.
    looked_at : tuple of Wanted
        Entries for a sample of the pairs, if there are too many pairs to list in `wanted`.
    pairs : int
        Approximate number of pairs, if there are too many to list.
    """

    wanted: tuple[Wanted, ...]
    grim: bool
    grimmer: bool
    reason: str
    refused: str = ""
    looked_at: tuple[Wanted, ...] = ()
    pairs: int = 0

    @property
    def moments(self) -> tuple[Moments, ...]:
        """Sums and sums of squares of the ratings that match the published numbers."""
        return tuple(wish.moments for wish in self.wanted)


def targets(column: Column) -> Targets:
    """Return the requirements that the ratings of `column` must meet."""
    sums = admissible_sums(column)
    reason = impossible(column)
    number = _number_of_pairs(column, sums)
    if max(number, len(sums)) > MOST_PAIRS:
        if reason:
            return Targets((), grim=True, grimmer=True, reason=reason)
        return _unlisted(column, sums, number)
    pairs = [(s, q) for s in sums for q in admissible_squares(column, s)]
    possible: tuple[Wanted, ...] = ()
    if pairs and not reason:
        try:
            extremes = _Extremes(column)
            wanted = [extremes.beside(Moments(column.n, *pair)) for pair in pairs]
        except _TooManyValues as too_many:
            return Targets((), grim=True, grimmer=True, reason="", refused=str(too_many))
        possible = tuple(wish for wish in wanted if wish is not None)
    if not reason and not possible:
        if not sums:
            reason = _grim_reason(column)
        elif not pairs:
            reason = _grimmer_reason(column)
        else:
            reason = (
                "no set of ratings on the scale has the published extreme values, median or "
                "frequencies"
            )
    return Targets(possible, grim=bool(sums), grimmer=bool(pairs), reason=reason)


def plain_sums(column: Column) -> dict[int, range] | None:
    """Return the possible sums of squares for each possible sum of the ratings.

    Returns None if the sums are too many to list, if other published numbers restrict the ratings,
    or if the column is impossible.
    """
    more = (
        column.maximum_deviation,
        column.observed_minimum,
        column.observed_maximum,
        column.median,
    )
    restricted = column.present or column.absent or column.frequencies or column.percentages
    if restricted or any(more) or impossible(column):
        return None
    sums = admissible_sums(column)
    if len(sums) > MOST_SUMS:
        return None
    return {total: squares for total in sums if (squares := admissible_squares(column, total))}


def _number_of_pairs(column: Column, sums: range) -> int:
    """Estimate how many pairs of sum and sum of squares match the published numbers."""
    # About the same number of sums of squares is possible for every sum.
    middle = admissible_squares(column, sums[len(sums) // 2]) if sums else range(0)
    return len(sums) * len(middle)


def _unlisted(column: Column, sums: range, number: int) -> Targets:
    """Return some of the requirements, for a column that has too many to list."""
    places = {len(sums) * (2 * i + 1) // (2 * LOOKED_AT) for i in range(LOOKED_AT)}
    some = (sums[place] for place in sorted(places))
    middles = ((total, admissible_squares(column, total)) for total in some)
    try:
        extremes = _Extremes(column)
        wanted = [
            extremes.beside(Moments(column.n, total, squares[len(squares) // 2]))
            for total, squares in middles
            if squares
        ]
    except _TooManyValues:
        wanted = []
    reason = (
        f"about {number:,} pairs of a sum and a sum of squares match the published mean and SD"
        if number
        else f"{len(sums):,} sums match the published mean"
    )
    return Targets(
        (),
        grim=True,
        grimmer=True,
        reason="",
        refused=(
            f"{reason}, which is more than the limit of {MOST_PAIRS:,}: the published "
            f"numbers have too few decimals for n = {column.n:,} on this scale"
        ),
        looked_at=tuple(wish for wish in wanted if wish is not None),
        pairs=number,
    )


def within_reach(moments: Moments, most: int) -> tuple[int, int]:
    """Return a lower and an upper bound on every value in a sample with the given moments.

    The values of the sample lie between 0 and `most`.

    According to Samuelson (1968), the squared distance of any value from the mean is at most (n -
    1) / n of the sum of squared deviations.

    >>> within_reach(Moments(5, 250, 12504), 100)
    (49, 51)
    """
    n, total = moments.n, moments.total
    # (n x - total)² <= (n - 1) (n squares - total²)
    root = isqrt(max((n - 1) * (n * moments.squares - total**2), 0))
    return max(-((root - total) // n), 0), min((total + root) // n, most)


def admissible_sums(column: Column) -> range:
    """Return the sums of ratings that match the published mean or sum."""
    n, scale = Fraction(column.n), column.scale
    found = Interval(Fraction(0), n * scale.steps)
    for printed, factor in column.means():
        mean = printed.values(column.rounding).scaled(1 / factor)
        found = found.meet(_steps(column, mean).scaled(n))
    return found.integers()


def admissible_squares(column: Column, total: int) -> range:
    """Return the sums of squared ratings that match the published SD, SE and confidence interval.

    The sum and the sum of squares have the same parity, so only every second sum of squares is
    possible.
    """
    n, steps = column.n, column.scale.steps
    variance = variances(column, column.scale.minimum + column.scale.step * Fraction(total, n))
    degrees = n - 1 if column.sd_convention == "sample" else n
    found = variance.scaled(degrees / column.scale.step**2, Fraction(total * total, n))
    # No rating lies outside the scale: x (steps - x) >= 0.
    squares = found.meet(Interval(Fraction(0), Fraction(total * steps))).integers()
    first = squares.start + (squares.start - total) % 2
    return range(first, max(squares.stop, first), 2)


# Maximum relative error of the squared quantile of a confidence interval.
QUANTILE_ERROR = Fraction(1, 10**9)


def variances(column: Column, mean: Fraction) -> Interval:
    """Return the variances that match the published SD, SE and confidence interval."""
    found = Interval(Fraction(0), (column.scale.maximum - column.scale.minimum) ** 2 * column.n)
    n = Fraction(column.n)
    if column.sd is not None:
        found = found.meet(column.sd.values(column.rounding).squared())
    if column.se is not None:
        found = found.meet(column.se.values(column.rounding).squared().scaled(n))
    if column.ci_low is not None and column.ci_high is not None:
        low, high = (end.values(column.rounding) for end in (column.ci_low, column.ci_high))
        below = Interval(mean - low.high, mean - low.low, low.high_closed, low.low_closed)
        above = Interval(high.low - mean, high.high - mean, high.low_closed, high.high_closed)
        half = below.meet(above)
        if half.high < 0 or half.low > half.high:
            return Interval(Fraction(1), Fraction(0))
        factor = n / Fraction(column.quantile) ** 2
        squared = half.squared()
        found = found.meet(
            Interval(
                squared.low * factor * (1 - QUANTILE_ERROR),
                squared.high * factor * (1 + QUANTILE_ERROR),
            )
        )
    return found


def _steps(column: Column, values: Interval) -> Interval:
    scale = column.scale
    return values.scaled(1 / scale.step, -scale.minimum / scale.step)


class _TooManyValues(Exception):
    """Raised if too many ratings match the published extreme values or median."""


class _Extremes:
    """The requirements that follow from published extreme values, medians and frequencies.

    Raises
    ------
    _TooManyValues
        If the scale is so fine that the candidates for extreme or middle ratings need gigabytes of
        memory. The method `beside` raises the same error.
    """

    def __init__(self, column: Column) -> None:
        self.column, self.steps = column, column.scale.steps
        self.listed = 0
        self.medians: dict[tuple[int, int], tuple[tuple[int, int], ...] | None] = {}
        self.told = occurrences(column)
        low, high = 0, self.steps
        self.present: list[frozenset[int]] = []
        if column.observed_minimum:
            found = _steps(column, column.observed_minimum.values(column.rounding)).integers()
            low = max(low, found.start)
            self.present.append(self._listed(found))
        if column.observed_maximum:
            found = _steps(column, column.observed_maximum.values(column.rounding)).integers()
            high = min(high, found.stop - 1)
            self.present.append(self._listed(found))
        self.low, self.high = low, high

    def _count(self, values: int) -> None:
        self.listed += values
        if self.listed > MOST_VALUES:
            raise _TooManyValues(
                f"more than {MOST_VALUES:,} ratings match the published extreme values or median: "
                f"too few decimals are published for steps of {self.column.scale.step}"
            )

    def _listed(self, values: range) -> frozenset[int]:
        self._count(len(values))
        return frozenset(values)

    def beside(self, moments: Moments) -> Wanted | None:
        """Return the requirements on ratings with these moments, or None if they cannot be met."""
        low, high = within_reach(moments, self.steps)
        low, high, present = max(low, self.low), min(high, self.high), self.present
        if self.column.maximum_deviation:
            inside, shell = self._shell(moments)
            low, high = max(low, inside.start), min(high, inside.stop - 1)
            present = [*present, shell]
        if present:
            self._count(sum(map(len, present)))
            present = [frozenset(v for v in wish if low <= v <= high) for wish in present]
            if not all(present):
                return None
        # Ratings beyond the bounds are impossible.
        if any(least for value, least, _ in self.told if not low <= value <= high):
            return None
        told = tuple(entry for entry in self.told if low <= entry[0] <= high)
        if (low, high) not in self.medians:
            self.medians[low, high] = self._medians(low, high)
        return Wanted(moments, low, high, tuple(present), self.medians[low, high], told)

    def _shell(self, moments: Moments) -> tuple[range, frozenset[int]]:
        """Return the ratings within the published maximum deviation, and those that attain it."""
        printed, one = self.column.maximum_deviation, Fraction(1)
        if printed is None:
            return range(self.steps + 1), frozenset()
        mean = Fraction(moments.total, moments.n)
        allowed = printed.values(self.column.rounding).scaled(one / self.column.scale.step)
        above, below = (allowed.scaled(one, shift).integers() for shift in (mean, -mean))
        edge = allowed.high_closed
        inside = Interval(mean - allowed.high, mean + allowed.high, edge, edge).integers()
        self._count(len(above) + len(below))
        return inside, frozenset(above) | frozenset(-v for v in below)

    def _medians(self, low: int, high: int) -> tuple[tuple[int, int], ...] | None:
        column = self.column
        if column.median is None:
            return None
        middle = _steps(column, column.median.values(column.rounding))
        twice = middle.scaled(Fraction(2)).integers()
        if column.n % 2:
            self._count(len(twice))
            return tuple((t // 2, t // 2) for t in twice if t % 2 == 0 and low <= t // 2 <= high)
        pairs: list[tuple[int, int]] = []
        for t in twice:
            lower = range(max(low, t - high), t // 2 + 1)
            self._count(len(lower))
            pairs += [(a, t - a) for a in lower if t - a <= high]
        return tuple(pairs)


def _grim_reason(column: Column) -> str:
    step, n = column.scale.step, column.n
    reasons = []
    for printed, factor in column.means():
        mean = printed.value / factor
        below = (mean - column.scale.minimum) * n / step // 1
        near = [float((column.scale.minimum + (below + i) * step / n) * factor) for i in (0, 1)]
        allowed = _steps(column, printed.values(column.rounding).scaled(1 / factor))
        if not allowed.scaled(Fraction(n)).integers():
            name = "sum" if printed is column.sum else "mean"
            reasons.append(
                f"GRIM: no {name} of {n} ratings in steps of {step} is printed as {printed.text}; "
                f"the nearest are {near[0]:.6g} and {near[1]:.6g}"
            )
    texts = " and ".join(printed.text for printed, _ in column.means())
    return "; ".join(reasons) or f"GRIM: {texts}, printed for the same mean, contradict each other"


def _grimmer_reason(column: Column) -> str:
    printed = {
        f"a {column.sd_convention} standard deviation of": column.sd,
        "a standard error of": column.se,
        "a confidence interval from": column.ci_low,
    }
    given = " and ".join(f"{words} {number.text}" for words, number in printed.items() if number)
    mean = next(text.text for text, _ in column.means())
    return f"GRIMMER: no sum of squares of {column.n} ratings with mean {mean} gives {given}"
