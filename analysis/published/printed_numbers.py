"""Represent a published number by the interval of exact values that round to it.

All computations use exact fractions, so floating-point errors cannot affect the rounding of a value
half-way between two decimals.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, floor


@dataclass(frozen=True)
class Interval:
    """An interval between two fractions, which may be closed, half-open or open."""

    low: Fraction
    high: Fraction
    low_closed: bool = True
    high_closed: bool = True

    def __contains__(self, value: Fraction) -> bool:
        above = value > self.low or (self.low_closed and value == self.low)
        below = value < self.high or (self.high_closed and value == self.high)
        return above and below

    def scaled(self, factor: Fraction, shift: Fraction = Fraction(0)) -> Interval:
        """Return the interval of ``factor * value + shift`` for a positive `factor`."""
        return Interval(
            self.low * factor + shift, self.high * factor + shift, self.low_closed, self.high_closed
        )

    def meet(self, other: Interval) -> Interval:
        """Return the intersection. An empty interval has `low` above `high`, or an open end."""
        low, high = max(self.low, other.low), min(self.high, other.high)
        return Interval(
            low,
            high,
            all(one.low_closed for one in (self, other) if one.low == low),
            all(one.high_closed for one in (self, other) if one.high == high),
        )

    def squared(self) -> Interval:
        """Return the interval of the squares of all non-negative values in the interval."""
        low = max(self.low, Fraction(0))
        closed = self.low_closed or low > self.low
        return Interval(low**2, self.high**2, closed, self.high_closed)

    def integers(self) -> range:
        """Return all integers in the interval."""
        first, last = ceil(self.low), floor(self.high)
        if not self.low_closed and first == self.low:
            first += 1
        if not self.high_closed and last == self.high:
            last -= 1
        return range(first, max(last + 1, first))


def _nearest(value: Fraction, unit: Fraction) -> Interval:
    return Interval(value - unit / 2, value + unit / 2)


def _half_up(value: Fraction, unit: Fraction) -> Interval:
    # "half_up" rounds away from zero, as in calculators and spreadsheets.
    low, high = value - unit / 2, value + unit / 2
    return Interval(low, high, low_closed=value >= unit, high_closed=value < 0)


def _half_even(value: Fraction, unit: Fraction) -> Interval:
    even = (value / unit) % 2 == 0
    return Interval(value - unit / 2, value + unit / 2, low_closed=even, high_closed=even)


def _truncated(value: Fraction, unit: Fraction) -> Interval:
    if value == 0:
        return Interval(-unit, unit, low_closed=False, high_closed=False)
    if value < 0:
        return Interval(value - unit, value, low_closed=False)
    return Interval(value, value + unit, high_closed=False)


# For each rounding rule, the exact values that it rounds to `value`, a multiple of `unit`.
RULES = {
    "nearest": _nearest,  # both ends are included, because the rule for halves is unknown
    "half_up": _half_up,
    "half_even": _half_even,
    "truncated": _truncated,
}


# Longer numbers are not measurements, and would slow down computations with fractions.
DECIMAL = re.compile(r"[+-]?(\d{1,15}(\.\d{0,15})?|\.\d{1,15})", re.ASCII)


def plain_decimal(text: str) -> str:
    """Convert a decimal number to ASCII, with a hyphen and a decimal point.

    >>> plain_decimal(" −0,50 ")
    '-0.50'

    Raises
    ------
    ValueError
        If the text is not a decimal number, or has more than 15 digits before or after the point.
    """
    found = text.strip().replace("\N{MINUS SIGN}", "-")
    if found.count(",") == 1 and "." not in found:
        found = found.replace(",", ".")
    if not DECIMAL.fullmatch(found):
        raise ValueError("expected a decimal number such as 12.75")
    return found


@dataclass(frozen=True)
class Printed:
    """A number as it was published, including trailing zeros.

    Examples
    --------
    >>> Printed("12.50").unit
    Fraction(1, 100)
    >>> Printed("12.5").values("nearest").low
    Fraction(249, 20)
    """

    text: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "text", plain_decimal(self.text))

    @property
    def value(self) -> Fraction:
        """The exact value of the published number."""
        return Fraction(self.text)

    @property
    def unit(self) -> Fraction:
        """One unit in the last published decimal place."""
        return Fraction(1, 10 ** len(self.text.partition(".")[2]))

    def values(self, rule: str) -> Interval:
        """Return the interval of exact values that `rule` rounds to this number."""
        return RULES[rule](self.value, self.unit)
