"""A confidence interval with its confidence level."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ConfidenceInterval:
    """The confidence bounds for a quantity, in its unit.

    Parameters
    ----------
    low, high : float
        Lower and upper bound. Unpacking the interval yields the lower and then the upper bound.
    confidence : float
        Confidence level of the interval, such as 0.95.
    """

    low: float
    high: float
    confidence: float = 0.95

    def __iter__(self) -> Iterator[float]:
        """Yield the lower and then the upper bound."""
        yield self.low
        yield self.high

    def json_form(self) -> tuple[float, float]:
        """Return ``[low, high]``."""
        return (self.low, self.high)


def key_of(interval: ConfidenceInterval | None) -> str:
    """Return the JSON key for an interval: "ci95" for a level of 0.95."""
    return "ci95" if interval is not None and interval.confidence == 0.95 else "ci"  # noqa: PLR2004
