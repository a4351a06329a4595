"""Format numbers for sentences, tables and figure captions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from slipscale.analysis.statistics.not_computed import NotComputed, fold

if TYPE_CHECKING:
    from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
    from slipscale.stimuli.quantity import Quantity

T = TypeVar("T")

#: Smaller values need more than two decimals.
SMALLEST_OF_TWO_DECIMALS = 0.095
#: Numbers in this range are written without decimals.
LARGE = (99.95, 1e5)
#: Placeholder for a missing number in a table.
DASH = "–"


def number(value: float | None, decimals: int = 2, *, thousands: str = "") -> str:
    """Format a number with fixed decimals and a true minus sign.

    Missing and infinite numbers give a dash. Negative numbers that round to 0 have no sign.

    >>> number(-1.5), number(float("nan")), number(1234567, 0, thousands=" "), number(-0.001)
    ('−1.50', '–', '1 234 567', '0.00')
    """
    if value is None or not math.isfinite(value):
        return DASH
    return f"{value:z,.{decimals}f}".replace(",", thousands).replace("-", "−")


def significant(value: float) -> str:
    """Format a number of any size with three significant digits.

    >>> significant(0.0213), significant(-1.234e-8), significant(float("nan")), significant(120)
    ('0.0213', '−1.23 × 10⁻⁸', '–', '120')
    """
    if not math.isfinite(value):
        return DASH
    if LARGE[0] <= abs(value) < LARGE[1]:
        return number(value, 0)
    figures, mark, power = f"{value:#.3g}".replace("-", "−").partition("e")
    return f"{figures} × 10{_raised(int(power.replace('−', '-')))}" if mark else figures


def measured(quantity: Quantity) -> Callable[[float | None], str]:
    """Return a function that formats estimated levels of a quantity.

    >>> from slipscale.stimuli.quantity import PLATE_AMPLITUDE, made_by_plate
    >>> measured(PLATE_AMPLITUDE)(1.2), measured(made_by_plate("voltage", "V", "peak"))(119.83)
    ('1.200', '120')
    """
    if quantity.of_plate:
        return partial(number, decimals=3)
    return lambda value: DASH if value is None else significant(value)


def _raised(power: int) -> str:
    return str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def of_size(value: float) -> Callable[[float], str]:
    """Return a function that formats a value and its interval with enough digits for both.

    >>> of_size(0.82)(0.05), of_size(0.0021)(0.0004)
    ('0.05', '0.000400')
    """
    return significant if 0 < abs(value) < SMALLEST_OF_TWO_DECIMALS else number


def grouped(value: float | None, decimals: int = 2) -> str:
    """Format a number for a table cell, with thousands separated by spaces.

    >>> grouped(1234.5)
    '1 234.50'
    """
    return number(value, decimals, thousands=" ")


def joined(words: Sequence[str]) -> str:
    """Join words with commas and a final "and".

    >>> joined(["a", "b", "c"]), joined(["a"])
    ('a, b and c', 'a')
    """
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def counted(count: int, one: str, many: str) -> str:
    """Format a count with its noun.

    >>> counted(1, "participant", "participants"), counted(0, "trial", "trials")
    ('1 participant', '0 trials')
    """
    return f"{grouped(count, 0)} {one if count == 1 else many}"


def p_value(p: float | None) -> str:
    """Format a p-value for a sentence.

    >>> p_value(0.0234), p_value(0.00012), p_value(0.9999), p_value(float("nan"))
    ('p = .023', 'p < .001', 'p > .999', 'p not defined')
    """
    if p is None or math.isnan(p):
        return "p not defined"
    if p < 0.001:  # noqa: PLR2004
        return "p < .001"
    if p > 0.999:  # noqa: PLR2004
        return "p > .999"
    return f"p = {unit_number(p, 3)}"


def p_cell(p: float | None) -> str:
    """Format a p-value for a table column with the heading p.

    >>> p_cell(0.02), p_cell(0.0001)
    ('.020', '< .001')
    """
    return p_value(p).removeprefix("p ").removeprefix("= ")


def unit_number(value: float, decimals: int = 2) -> str:
    """Format a number between -1 and 1 without a leading zero.

    >>> unit_number(0.517), unit_number(-0.2)
    ('.52', '−.20')
    """
    if not math.isfinite(value):
        return DASH
    text = f"{abs(value):.{decimals}f}"
    sign = "−" if value < 0 and float(text) else ""
    return sign + (text.removeprefix("0"))


def cell(result: T | NotComputed, write: Callable[[T], str]) -> str:
    """Format a result using the function ``write``, or return a dash if it was not computed."""
    return fold(result, write, lambda _: DASH)


def bracketed(bounds: ConfidenceInterval | None, write: Callable[[float], str] = number) -> str:
    """Format an interval as "[low, high]", or None as a dash; an end may have no limit."""
    if bounds is None:
        return DASH
    low, high = bounds
    ends = (
        write(low) if low > -math.inf else "no lower limit",
        write(high) if high < math.inf else "no upper limit",
    )
    return f"[{ends[0]}, {ends[1]}]"


def interval(low: float | None, high: float | None, decimals: int = 2) -> str:
    """Format an interval for a table cell; missing or infinite limits give a dash.

    >>> interval(0.4, 0.62)
    '[0.40, 0.62]'
    """
    if low is None or high is None or not (math.isfinite(low) and math.isfinite(high)):
        return DASH
    return f"[{grouped(low, decimals)}, {grouped(high, decimals)}]"


def level_of(confidence: float) -> str:
    """Format a confidence level, such as "95%"."""
    return f"{round(100 * confidence, 6):g}%"
