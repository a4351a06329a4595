"""From printed numbers to what whole ratings must add up to; GRIM and GRIMMER reasons.

Ratings are counted in steps above the scale's minimum, so every quantity here is a whole
number. GRIM (Brown and Heathers, 2017) asks whether n whole numbers can have the printed mean;
GRIMMER (Anaya, 2016; Allard, 2018) whether a whole sum of squares of the right parity gives
the printed standard deviation. Both are necessary, neither is sufficient: the count decides.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import isqrt
from typing import TYPE_CHECKING

from analysis.reconstruction.partition import Moments, Wanted
from analysis.reconstruction.rounding import Interval

if TYPE_CHECKING:
    from analysis.reconstruction.published_table import Column


# Pairs of a sum and a sum of squares that are looked at one by one.
MOST_PAIRS = 100_000
# Of more, so many sums are looked at, each with its middle sum of squares.
LOOKED_AT = 9


@dataclass(frozen=True)
class Targets:
    """What a column's ratings, in steps above the minimum, must meet.

    Parameters
    ----------
    wanted : tuple of Wanted
        One for each admissible sum and sum of squares.
    grim : bool
        Whether some sum gives the printed mean.
    grimmer : bool
        Whether some sum of squares, too, gives the printed standard deviation.
    reason : str
        Why not, if not; empty otherwise.
    refused : str
        Why they cannot be listed; then `wanted` is empty without meaning anything.
    looked_at : tuple of Wanted
        Some of them, where they are not listed.
    pairs : int
        About how many there are, where they are not listed.
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
        """The admissible sums and sums of squares, in steps above the minimum."""
        return tuple(wish.moments for wish in self.wanted)


def targets(column: Column) -> Targets:
    """Return what the ratings of `column` must meet."""
    sums = admissible_sums(column)
    reason = impossible(column)
    if not reason and (number := _number_of_pairs(column, sums)) > MOST_PAIRS:
        return _unlisted(column, sums, number)
    pairs = [(s, q) for s in sums for q in admissible_squares(column, s)]
    wanted = [_wanted(column, Moments(column.n, total, squares)) for total, squares in pairs]
    possible = tuple(wish for wish in wanted if wish is not None)
    if not reason and not possible:
        if not sums:
            reason = _grim_reason(column)
        elif not pairs:
            reason = _grimmer_reason(column)
        else:
            reason = "no rating on the scale gives the printed extremes or median"
    return Targets(() if reason else possible, grim=bool(sums), grimmer=bool(pairs), reason=reason)


# A smaller number and a larger one, as printed.
ORDERED = (
    ("observed_minimum", "observed_maximum"),
    ("observed_minimum", "median"),
    ("median", "observed_maximum"),
    ("observed_minimum", "mean"),
    ("mean", "observed_maximum"),
)


def impossible(column: Column) -> str:
    """Return what no ratings on the scale can have, however rounded; empty if there is nothing."""
    low, high = column.scale.minimum, column.scale.maximum
    found = []
    for name in ("mean", "median", "observed_minimum", "observed_maximum"):
        printed = getattr(column, name)
        if printed and not low - printed.unit < printed.value < high + printed.unit:
            found.append(f"{name} {printed.text} lies outside the scale, {low} to {high}")
    for name in ("sd", "maximum_deviation"):
        printed = getattr(column, name)
        if printed and printed.value - printed.unit >= high - low:
            found.append(f"{name} {printed.text} is impossible on a scale from {low} to {high}")
    for smaller, larger in ORDERED:
        a, b = getattr(column, smaller), getattr(column, larger)
        if a and b and a.value - a.unit >= b.value + b.unit:
            found.append(f"{smaller} {a.text} and {larger} {b.text} contradict each other")
    return "; ".join(found)


def _number_of_pairs(column: Column, sums: range) -> int:
    """Return about how many sums and sums of squares the printed decimals admit."""
    # They differ little from sum to sum.
    middle = admissible_squares(column, sums[len(sums) // 2]) if sums else range(0)
    return len(sums) * len(middle)


def _unlisted(column: Column, sums: range, number: int) -> Targets:
    """Say that there are too many to list, and look at some."""
    places = {len(sums) * (2 * i + 1) // (2 * LOOKED_AT) for i in range(LOOKED_AT)}
    some = (sums[place] for place in sorted(places))
    middles = ((total, admissible_squares(column, total)) for total in some)
    wanted = (
        _wanted(column, Moments(column.n, total, squares[len(squares) // 2]))
        for total, squares in middles
        if squares
    )
    return Targets(
        (),
        grim=True,
        grimmer=True,
        reason="",
        refused=(
            f"about {number:,} pairs of a sum and a sum of squares give the printed mean and SD, "
            f"more than {MOST_PAIRS:,}: too few decimals for n = {column.n:,} on this scale"
        ),
        looked_at=tuple(wish for wish in wanted if wish is not None),
        pairs=number,
    )


def within_reach(moments: Moments, most: int) -> tuple[int, int]:
    """Return the least and the largest value that may occur beside these sums, from 0 to `most`.

    None of n values lies farther from their mean than (n - 1) / n of the sum of squared
    deviations allows (Samuelson, 1968).

    >>> within_reach(Moments(5, 250, 12504), 100)
    (49, 51)
    """
    n, total = moments.n, moments.total
    # (n x - total)² <= (n - 1) (n squares - total²)
    root = isqrt(max((n - 1) * (n * moments.squares - total**2), 0))
    return max(-((root - total) // n), 0), min((total + root) // n, most)


def admissible_sums(column: Column) -> range:
    """Return the sums, in steps above the minimum, that give the printed mean."""
    mean = _steps(column, column.mean.values(column.rounding))
    found = mean.scaled(Fraction(column.n)).integers()
    most = column.n * column.scale.steps
    return range(max(found.start, 0), min(found.stop, most + 1))


def admissible_squares(column: Column, total: int) -> range:
    """Return the sums of squares, in steps, that give the printed SD beside a sum `total`.

    A whole number and its square have the same parity, so only every other one is possible.
    """
    sd = column.sd.values(column.rounding)
    low = max(sd.low, Fraction(0))
    variance = Interval(
        low**2, sd.high**2, sd.low_closed if low == sd.low else True, sd.high_closed
    )
    degrees = column.n - 1 if column.sd_convention == "sample" else column.n
    found = variance.scaled(
        degrees / column.scale.step**2, Fraction(total * total, column.n)
    ).integers()
    first = found.start + (found.start - total) % 2
    return range(first, found.stop, 2)


def _steps(column: Column, values: Interval) -> Interval:
    """Return an interval of ratings in steps above the scale's minimum."""
    scale = column.scale
    return values.scaled(1 / scale.step, -scale.minimum / scale.step)


def _wanted(column: Column, moments: Moments) -> Wanted | None:
    """Add what the extremes and the median ask; None if no rating can meet it."""
    low, high = within_reach(moments, column.scale.steps)
    present: list[frozenset[int]] = []
    if column.observed_minimum:
        found = _steps(column, column.observed_minimum.values(column.rounding)).integers()
        low = max(low, found.start)
        present.append(frozenset(found))
    if column.observed_maximum:
        found = _steps(column, column.observed_maximum.values(column.rounding)).integers()
        high = min(high, found.stop - 1)
        present.append(frozenset(found))
    if column.maximum_deviation:
        mean, one = Fraction(moments.total, moments.n), Fraction(1)
        allowed = column.maximum_deviation.values(column.rounding).scaled(one / column.scale.step)
        above, below = (allowed.scaled(one, shift).integers() for shift in (mean, -mean))
        shell = frozenset(above) | frozenset(-v for v in below)
        edge = allowed.high_closed
        inside = Interval(mean - allowed.high, mean + allowed.high, edge, edge).integers()
        low, high = max(low, inside.start), min(high, inside.stop - 1)
        present.append(shell)
    present = [frozenset(v for v in wish if low <= v <= high) for wish in present]
    if not all(present):
        return None
    return Wanted(moments, low, high, tuple(present), _medians(column, low, high))


def _medians(column: Column, low: int, high: int) -> tuple[tuple[int, int], ...] | None:
    """Return the pairs of middle values that give the printed median."""
    if column.median is None:
        return None
    twice = _steps(column, column.median.values(column.rounding)).scaled(Fraction(2)).integers()
    if column.n % 2:
        return tuple((t // 2, t // 2) for t in twice if t % 2 == 0 and low <= t // 2 <= high)
    return tuple(
        (a, t - a) for t in twice for a in range(max(low, t - high), t // 2 + 1) if t - a <= high
    )


def _grim_reason(column: Column) -> str:
    step, n = column.scale.step, column.n
    below = (column.mean.value - column.scale.minimum) * n / step // 1
    near = [float(column.scale.minimum + (below + i) * step / n) for i in (0, 1)]
    return (
        f"GRIM: no mean of {n} ratings in steps of {step} is printed as {column.mean.text}; "
        f"the nearest are {near[0]:.6g} and {near[1]:.6g}"
    )


def _grimmer_reason(column: Column) -> str:
    return (
        f"GRIMMER: no sum of squares of {column.n} ratings with mean {column.mean.text} gives a "
        f"{column.sd_convention} standard deviation of {column.sd.text}"
    )
