"""A confidence interval, with its level."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator


@dataclass(frozen=True, slots=True)
class ConfidenceInterval:
    """Bounds of a quantity, in its unit.

    Parameters
    ----------
    low, high : float
        Bounds; unpacking gives these two.
    confidence : float
        Level, such as 0.95.
    """

    low: float
    high: float
    confidence: float = 0.95

    def __iter__(self) -> Iterator[float]:
        """Give the lower and the upper bound."""
        yield self.low
        yield self.high
