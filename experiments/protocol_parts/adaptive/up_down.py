"""Up-down methods, in which the level falls after correct answers and rises after an error.

These methods converge to the level at which steps down and up balance. If ``k`` correct answers in
a row lead to a step down of size d, and one error to a step up of size u, this is the level where
``p**k d = (1 - p**k) u`` (Kaernbach 1991, Perception & Psychophysics 49, 227-229, for k = 1;
García-Pérez 1998, Vision Research 38, 1861-1881, for the ratios at which finite steps converge to
this level).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, Self

from slipscale.experiments.protocol_parts.adaptive.track import (
    Progress,
    check_between,
    check_positive,
)
from slipscale.experiments.steps.rounding import DECIMALS, rounded
from slipscale.faults import UserError

Scale = Literal["linear", "log10"]
DOWN, UP = -1, 1


@dataclass(frozen=True, slots=True, kw_only=True)
class UpDown:
    """A rule that lowers the level after correct answers and raises it after an error.

    Parameters
    ----------
    start_level : float
        Level of the first trial, µm peak to peak.
    lowest_level, highest_level : float
        Limits of the level; a step beyond a limit ends at the limit.
    steps_up : tuple of float
        Sizes of the steps up. The first size applies until the first reversal, the second until
        the second reversal, and so on; the last size applies to all later steps. Sizes are in
        µm on the linear scale and in decades on the logarithmic scale.
    down_to_up : float
        Size of a step down relative to a step up.
    down_after : int
        Number of correct answers in a row before a step down.
    scale : {"linear", "log10"}
        Whether steps add to the level (linear) or multiply the level (log10).
    until_first_error : bool
        Whether every correct answer before the first error leads to a step down.

    Raises
    ------
    UserError
        If a parameter is out of range, the start level is outside the limits, or a step is larger
        than the range of levels.
    """

    start_level: float
    lowest_level: float
    highest_level: float
    steps_up: tuple[float, ...]
    down_to_up: float
    down_after: int = 1
    scale: Scale = "log10"
    until_first_error: bool = False

    def __post_init__(self) -> None:
        where = "staircase"
        if not self.steps_up:
            raise UserError(
                "{where}: steps_up is empty, expected at least one step size", where=where
            )
        check_positive(where, "steps_up", self.steps_up)
        check_positive(where, "down_to_up", [self.down_to_up])
        if self.down_after < 1:
            raise UserError(
                "{where}: down_after is {down_after}, expected 1 or more",
                where=where,
                down_after=self.down_after,
            )
        least = 0.0 if self.scale == "linear" else 10.0**-DECIMALS
        if not (math.isfinite(self.lowest_level) and self.lowest_level >= least):
            raise UserError(
                "{where}: the lowest level is {lowest_level:g}, expected {least:g} or more on "
                "the {scale} scale",
                where=where,
                lowest_level=self.lowest_level,
                least=least,
                scale=self.scale,
            )
        if not (math.isfinite(self.highest_level) and self.highest_level > self.lowest_level):
            raise UserError(
                "{where}: the highest level is {highest_level:g}, expected above the lowest "
                "({lowest_level:g})",
                where=where,
                highest_level=self.highest_level,
                lowest_level=self.lowest_level,
            )
        check_between(
            where, "the first level", self.start_level, self.lowest_level, self.highest_level
        )
        span = self.coordinate(self.highest_level) - self.coordinate(self.lowest_level)
        if max(self.steps_up) > span:
            unit = "" if self.scale == "linear" else " decades"
            raise UserError(
                "{where}: a step up of {largest_step:g}{unit} is larger than the whole range of"
                " levels ({span:.3g}{unit})",
                where=where,
                largest_step=max(self.steps_up),
                unit=unit,
                span=span,
            )

    @property
    def target(self) -> float:
        """Proportion of correct answers to which tracks converge."""
        return float((1 / (1 + self.down_to_up)) ** (1 / self.down_after))

    def start(self) -> UpDownTrack:
        """Return a track in its initial state, before the first trial."""
        return UpDownTrack(rule=self, level=self.start_level)

    def moved(self, level: float, direction: int, reversals: int) -> float:
        """Return the level after one step up (1) or down (-1), within the limits."""
        up = self.steps_up[min(reversals, len(self.steps_up) - 1)]
        step = up if direction == UP else -up * self.down_to_up
        new = level + step if self.scale == "linear" else level * 10.0**step
        return min(max(rounded(new), self.lowest_level), self.highest_level)

    def coordinate(self, level: float) -> float:
        """Convert a level to a position on the step scale (linear or log10)."""
        return level if self.scale == "linear" else math.log10(level)

    def level_at(self, coordinate: float) -> float:
        """Convert a position on the step scale (linear or log10) to a level."""
        return coordinate if self.scale == "linear" else 10.0**coordinate


@dataclass(frozen=True, slots=True, kw_only=True)
class UpDownTrack:
    """Immutable state of an up-down run.

    Parameters
    ----------
    rule : UpDown
        The rule that changes the level.
    level : float
        Level of the next trial.
    trials : int
        Number of answers so far.
    correct_in_row : int
        Number of correct answers since the last step.
    direction : int
        Direction of the last step: -1 down, 1 up, 0 before the first step.
    reversal_levels : tuple of float
        Levels at which the direction of the steps changed, in order of occurrence.
    """

    rule: UpDown
    level: float
    trials: int = 0
    correct_in_row: int = 0
    direction: int = 0
    reversal_levels: tuple[float, ...] = ()

    @property
    def progress(self) -> Progress:
        """Number of trials and reversals so far."""
        return Progress(trials=self.trials, reversals=len(self.reversal_levels))

    def answered(self, *, correct: bool, at_level: float | None = None) -> Self:  # noqa: ARG002
        """Return the track after one more answer. Up-down rules ignore ``at_level``."""
        in_row = self.correct_in_row + 1 if correct else 0
        beginning = self.rule.until_first_error and self.direction != UP
        needed = 1 if beginning and not self.reversal_levels else self.rule.down_after
        if correct and in_row < needed:
            return self._after(in_row, self.direction, self.level, ())
        direction = DOWN if correct else UP
        turned = (self.level,) if self.direction == -direction else ()
        reversals = len(self.reversal_levels) + len(turned)
        level = self.rule.moved(self.level, direction, reversals)
        return self._after(0, direction, level, turned)

    def _after(self, in_row: int, direction: int, level: float, turned: tuple[float, ...]) -> Self:
        return type(self)(
            rule=self.rule,
            level=level,
            trials=self.trials + 1,
            correct_in_row=in_row,
            direction=direction,
            reversal_levels=self.reversal_levels + turned,
        )
