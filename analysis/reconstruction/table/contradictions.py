"""Find published numbers that are impossible on the scale or contradict each other."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from slipscale.analysis.published.printed_numbers import Printed
    from slipscale.analysis.reconstruction.table.published_table import Column

# Pairs of printed numbers of which the first must not exceed the second.
ORDERED = (
    ("ci_low", "mean"),
    ("mean", "ci_high"),
    ("observed_minimum", "lower_quartile"),
    ("lower_quartile", "median"),
    ("median", "upper_quartile"),
    ("lower_quartile", "upper_quartile"),
    ("upper_quartile", "observed_maximum"),
    ("observed_minimum", "observed_maximum"),
    ("observed_minimum", "median"),
    ("median", "observed_maximum"),
    ("observed_minimum", "mean"),
    ("mean", "observed_maximum"),
)


# Published numbers that must be within the range of the scale.
INSIDE = (
    "mean",
    "median",
    "observed_minimum",
    "observed_maximum",
    "lower_quartile",
    "upper_quartile",
)


def impossible(column: Column) -> str:
    """Explain which published numbers are impossible under any rounding rule, or return ""."""
    low, high = column.scale.minimum, column.scale.maximum
    found = []
    for name in INSIDE:
        printed = getattr(column, name)
        if printed and not low - printed.unit < printed.value < high + printed.unit:
            found.append(f"{name} {printed.text} lies outside the scale from {low} to {high}")
    for name in ("sd", "maximum_deviation"):
        printed = getattr(column, name)
        if printed and printed.value - printed.unit >= high - low:
            found.append(f"{name} {printed.text} is impossible on a scale from {low} to {high}")
    for smaller, larger in ORDERED:
        a, b = getattr(column, smaller), getattr(column, larger)
        if a and b and a.value - a.unit >= b.value + b.unit:
            found.append(f"{smaller} {a.text} and {larger} {b.text} contradict each other")
    found += [
        f"the rating {value} lies outside the scale from {low} to {high}"
        for value, least in _told_to_occur(column)
        if least and column.scale.steps_to(value) is None
    ]
    return "; ".join(found + list(_impossible_shares(column)))


def _told_to_occur(column: Column) -> Iterator[tuple[Fraction, int]]:
    """Yield the ratings that must occur, each with its minimum frequency."""
    yield from ((value, 1) for value in column.present)
    yield from column.frequencies
    yield from ((v, _occurrences(column, share).start) for v, share in column.percentages)


def _impossible_shares(column: Column) -> Iterator[str]:
    """Yield errors for impossible percentages, and for frequencies that sum to more than n."""
    for value, printed in column.percentages:
        if not _occurrences(column, printed):
            yield f"GRIM: no count out of {column.n} gives {printed.text} % for the rating {value}"
    fewest = sum(least for _, least, _ in occurrences(column))
    if fewest > column.n:
        yield f"the stated frequencies add up to at least {fewest}, but n is {column.n}"


def _occurrences(column: Column, printed: Printed) -> range:
    """Return the possible frequencies of a rating, given its percentage."""
    found = printed.values(column.rounding).scaled(Fraction(column.n, 100)).integers()
    return range(max(found.start, 0), min(found.stop, column.n + 1))


def occurrences(column: Column) -> tuple[tuple[int, int, int], ...]:
    """Return the ratings with stated frequencies, each with its minimum and maximum frequency.

    Each rating is returned as a number of steps above the scale minimum. Ratings outside the scale
    are omitted.
    """
    stated = [
        *((value, range(1, column.n + 1)) for value in column.present),
        *((value, range(1)) for value in column.absent),
        *((value, range(times, times + 1)) for value, times in column.frequencies),
        *((value, _occurrences(column, printed)) for value, printed in column.percentages),
    ]
    placed = ((column.scale.steps_to(value), times) for value, times in stated)
    return tuple(
        (steps, times.start, times.stop - 1)
        for steps, times in placed
        if steps is not None and times
    )
