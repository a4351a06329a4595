"""Parse numbers as printed in papers, for the fields of a table file."""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated

from pydantic import BeforeValidator, Field, InstanceOf

from slipscale.analysis.published.printed_numbers import Printed, plain_decimal


def _printed(value: object) -> Printed:
    return value if isinstance(value, Printed) else Printed(_text(value))


def exact(value: object) -> Fraction:
    """Convert a number such as 1, 0.5 or 1/3 to a fraction."""
    if isinstance(value, Fraction):
        return value
    try:
        top, _, bottom = _text(value).partition("/")
        return Fraction(plain_decimal(top)) / Fraction(plain_decimal(bottom or "1"))
    except (ValueError, ZeroDivisionError):
        raise ValueError("expected a number such as 1, 0.5 or 1/3") from None


def _text(value: object) -> str:
    return str(value) if isinstance(value, str | int) else ""


def _words(value: object) -> object:
    return value.split() if isinstance(value, str) else value


def _by_value(value: object) -> object:
    """Convert a table, or a CSV cell such as "0:3 7:1", to pairs of rating and number."""
    if isinstance(value, str):
        return [tuple(part.rpartition(":")[::2]) for part in value.split()]
    return list(value.items()) if isinstance(value, dict) else value


Exact = Annotated[InstanceOf[Fraction], BeforeValidator(exact)]
AsPrinted = Annotated[InstanceOf[Printed], BeforeValidator(_printed)]
Values = Annotated[tuple[Exact, ...], BeforeValidator(_words)]
Counts = Annotated[
    tuple[tuple[Exact, Annotated[int, Field(ge=0)]], ...], BeforeValidator(_by_value)
]
Shares = Annotated[tuple[tuple[Exact, AsPrinted], ...], BeforeValidator(_by_value)]
