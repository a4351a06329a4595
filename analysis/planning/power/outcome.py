"""Count significant results in simulated studies, as sums that can be added across shards."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

#: Standard normal quantile for a 95 % interval.
Z95 = 1.959963984540054


@dataclass(frozen=True, slots=True, kw_only=True)
class Share:
    """Proportion of simulated studies, with its Monte Carlo interval.

    Parameters
    ----------
    value : float
    low, high : float
        95 % interval (Wilson, 1927, Journal of the American Statistical Association 22, 209-212).
    studies : int
    """

    value: float
    low: float
    high: float
    studies: int

    @classmethod
    def of(cls, count: int, studies: int) -> Self:
        """Return the proportion ``count / studies`` with its Monte Carlo interval."""
        if not studies:
            return cls(value=math.nan, low=math.nan, high=math.nan, studies=0)
        share, z2 = count / studies, Z95**2
        centre = (share + z2 / (2 * studies)) / (1 + z2 / studies)
        spread = share * (1 - share) / studies + z2 / (4 * studies**2)
        half = Z95 * math.sqrt(spread) / (1 + z2 / studies)
        return cls(
            value=share,
            low=max(centre - half, 0.0),
            high=min(centre + half, 1.0),
            studies=studies,
        )

    @property
    def error(self) -> float:
        """Monte Carlo standard error of the proportion."""
        return math.sqrt(self.value * (1 - self.value) / self.studies)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sums:
    """Number of values, their sum, and the sum of their squares."""

    n: int = 0
    total: float = 0.0
    squares: float = 0.0

    @classmethod
    def of(cls, values: NDArray[np.float64]) -> Self:
        """Count the finite values, and sum these values and their squares."""
        finite = values[np.isfinite(values)]
        return cls(n=len(finite), total=float(finite.sum()), squares=float((finite**2).sum()))

    def __add__(self, other: Sums) -> Sums:
        return Sums(
            n=self.n + other.n,
            total=self.total + other.total,
            squares=self.squares + other.squares,
        )

    @property
    def mean(self) -> float:
        """Mean of the values; NaN if there are no values."""
        return self.total / self.n if self.n else math.nan

    @property
    def error(self) -> float:
        """Standard error of the mean; NaN for fewer than two values."""
        if self.n < 2:  # noqa: PLR2004
            return math.nan
        variance = max(self.squares - self.total**2 / self.n, 0.0) / (self.n - 1)
        return math.sqrt(variance / self.n)


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """Results of simulated studies, as counts and sums that can be added across shards.

    Parameters
    ----------
    studies : int
        Number of studies, including those that cannot be analysed, which count as not significant.
    unusable : int
        Number of studies that `analyse` would reject.
    found : Mapping
        Number of studies with a significant result, keyed by test, pair of neighbouring levels
        ("0.5 - 1.2") or interim analysis ("look after 12").
    widths : Mapping
        Half-widths of the confidence interval, keyed by estimated quantity ("exponent", "mean at
        0.5").
    steps : Mapping
        Precision provided by the catch steps (see
        `slipscale.analysis.planning.power.yes_no_steps.precision`); empty if not requested.
    """

    studies: int = 0
    unusable: int = 0
    found: Mapping[str, int] = field(default_factory=dict)
    widths: Mapping[str, Sums] = field(default_factory=dict)
    steps: Mapping[str, Sums] = field(default_factory=dict)

    def power(self, test: str) -> Share:
        """Return the proportion of studies in which a test was significant."""
        return Share.of(self.found[test], self.studies)

    def as_json(self) -> dict[str, object]:
        """Return the outcome as JSON data."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """Parse the output of `as_json`.

        Raises KeyError, TypeError or ValueError if the data are invalid.
        """
        return cls(
            studies=int(data["studies"]),
            unusable=int(data["unusable"]),
            found={str(name): int(count) for name, count in data["found"].items()},
            widths=_sums(data["widths"]),
            steps=_sums(data["steps"]),
        )


def _sums(data: Mapping[str, Any]) -> dict[str, Sums]:
    return {str(name): Sums(**sums) for name, sums in data.items()}


def _added(one: Mapping[str, Sums], other: Mapping[str, Sums]) -> dict[str, Sums]:
    return {name: one.get(name, Sums()) + sums for name, sums in other.items()}


def total(outcomes: Iterable[Outcome]) -> Outcome:
    """Sum outcomes in the given order, so that rounding is reproducible."""
    whole = Outcome()
    for one in outcomes:
        whole = Outcome(
            studies=whole.studies + one.studies,
            unusable=whole.unusable + one.unusable,
            found={name: whole.found.get(name, 0) + count for name, count in one.found.items()},
            widths=_added(whole.widths, one.widths),
            steps=_added(whole.steps, one.steps),
        )
    return whole
