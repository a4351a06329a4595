"""The common interface of adaptive methods, and checks of their parameters.

A level, in µm peak to peak, is an amplitude or the difference between two amplitudes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol, Self

from slipscale.faults import UserError


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """Progress of a track, evaluated by the stopping rules.

    Parameters
    ----------
    trials : int
        Number of answers so far.
    reversals : int or None
        Number of reversals of the step direction; None for a method without steps.
    threshold_sd_log10 : float or None
        Posterior standard deviation of the threshold, in decades; None if the method has no
        posterior.
    """

    trials: int
    reversals: int | None = None
    threshold_sd_log10: float | None = None


class Track(Protocol):
    """One run of an adaptive method, as an immutable state."""

    @property
    def level(self) -> float:
        """Level of the next trial, in µm peak to peak."""
        ...

    @property
    def progress(self) -> Progress:
        """Progress of the track, for the stopping rules."""
        ...

    def answered(self, *, correct: bool, at_level: float | None = None) -> Self:
        """Return the track after one more answer. In a yes-no task, "yes" counts as correct.

        The answer was given at the track's current level, or at ``at_level`` if the track is being
        recomputed. Up-down rules ignore ``at_level`` and move from their current level.
        """
        ...


def check_positive(where: str, name: str, values: Iterable[float]) -> None:
    """Raise `UserError` unless all values are finite and above 0."""
    for value in values:
        if not (math.isfinite(value) and value > 0):
            raise UserError(
                "{where}: {name} is {value:g}, expected a finite number above 0",
                where=where,
                name=name,
                value=value,
            )


def check_between(where: str, name: str, value: float, low: float, high: float) -> None:
    """Raise `UserError` unless a value is in the range from ``low`` to ``high``."""
    if not (math.isfinite(value) and low <= value <= high):
        raise UserError(
            "{where}: {name} is {value:g}, expected {low:g} to {high:g}",
            where=where,
            name=name,
            value=value,
            low=low,
            high=high,
        )
