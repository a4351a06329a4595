"""Represent a fitted psychometric function, and the answers used for the fit.

Each level is an amplitude (detection) or a difference between amplitudes (discrimination), in µm
peak to peak.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from slipscale.analysis.json_form import Unchanged, bounds
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.psychometric_fit import Array, Guess
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES
from slipscale.faults import UserError


@dataclass(frozen=True, slots=True, kw_only=True)
class Method:
    """The type of lower asymptote that a task's question implies.

    Parameters
    ----------
    guess : {"fixed", "free", "equal to lapse"}
        Whether the lower asymptote is fixed, estimated or equal to the lapse rate.
    guess_rate : float
        Value of the lower asymptote, if it is fixed.
    by_magnitude : bool
        Whether answers are choices by magnitude, such as the most slippery of the surfaces.
    """

    guess: Guess
    guess_rate: float
    by_magnitude: bool = True


METHODS: dict[str, Method] = {
    "two_interval": Method(guess="fixed", guess_rate=1 / 2),
    "three_interval": Method(guess="fixed", guess_rate=1 / 3),
    # For "Which is different?", the decision is the closest pair of three sensations, so that the
    # same proportion requires a larger d' than a choice by magnitude.
    "oddity": Method(guess="fixed", guess_rate=1 / 3, by_magnitude=False),
    # For "Was there a vibration?", the rate of false alarms depends on the participant.
    "yes_no": Method(guess="free", guess_rate=0.0),
    # Without catch trials, false alarms cannot be separated from answers to weak stimuli.
    "detection": Method(guess="fixed", guess_rate=0.0),
    # For "Is the second more slippery?", a lapse can produce either answer.
    "comparison": Method(guess="equal to lapse", guess_rate=0.0),
}


@dataclass(frozen=True, eq=False, kw_only=True)
class Answers:
    """The answers of one participant, counted by level.

    Parameters
    ----------
    levels : array, shape (levels,)
        Levels in ascending order.
    correct, trials : array, shape (levels,)
        Number of correct (or "yes") answers, and number of all answers.

    Raises
    ------
    UserError
        If the lengths differ, the levels are not ascending, or a count is impossible.
    """

    levels: Array
    correct: Array
    trials: Array

    def __post_init__(self) -> None:
        levels, correct, trials = self.levels, self.correct, self.trials
        if not levels.shape == correct.shape == trials.shape or levels.ndim != 1:
            raise UserError("answers: levels, correct and trials must have equal lengths")
        if not np.isfinite(levels).all() or np.any(np.diff(levels) <= 0):
            raise UserError("answers: levels must be finite and ascending")
        if np.any(trials < 1) or np.any(correct < 0) or np.any(correct > trials):
            raise UserError(
                "answers: each level needs at least one trial, and no more correct answers than "
                "trials"
            )

    @classmethod
    def of_trials(cls, levels: Sequence[float], correct: Sequence[bool]) -> Answers:
        """Summarise single trials, such as the trials of an adaptive track, as counts per level."""
        apart, place = np.unique(np.asarray(levels, float), return_inverse=True)
        return cls(
            levels=apart,
            correct=np.bincount(place, weights=np.asarray(correct, float)).astype(float),
            trials=np.bincount(place).astype(float),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """An estimate with its interval. The field that contains the estimate states the unit."""

    value: float
    interval: ConfidenceInterval


def estimate(value_and_ends: Array, confidence: float) -> Estimate:
    """Convert an array of a value and both ends of its interval to an `Estimate`."""
    value, low, high = (float(number) for number in value_and_ends)
    return Estimate(value=value, interval=ConfidenceInterval(low, high, confidence))


@dataclass(frozen=True, slots=True, kw_only=True)
class PsychometricFunction:
    """A fitted psychometric function.

    Parameters
    ----------
    estimator : {"maximum likelihood", "posterior"}
        Estimation method.
    curve, method : str
        Name of the curve (a key of `slipscale.experiments.protocol_parts.adaptive.curves.CURVES`),
        and name of the method of the experiment (a key of `METHODS`).
    share : float
        Value of the curve at the threshold, without guesses and lapses.
    threshold_level : Estimate
        Threshold. A limit of the interval is infinite if the data do not
        determine it; for a logarithmic curve, such a lower limit is 0.
    slope : Estimate or NotComputed
        Slope of the curve's argument per unit of the level; dimensionless for a logarithmic curve.
    lapse, guess : float
        Lapse rate (1 minus the upper asymptote), and lower asymptote.
    slope_value : float
        Estimated slope, also if `slope` is `NotComputed`.
    trials, levels : int
    """

    estimator: Literal["maximum likelihood", "posterior"]
    curve: str
    method: str
    share: float
    threshold_level: Estimate
    slope: Estimate | NotComputed
    slope_value: float
    lapse: float
    guess: float
    trials: int
    levels: int

    def proportion(self, levels: Array) -> Array:
        """Return the proportion correct at levels."""
        curve = CURVES[self.curve]
        z = float(curve.inverse(np.array(self.share))) + self.slope_value * (
            curve.coordinate(levels) - curve.coordinate(self.threshold_level.value)
        )
        return np.asarray(self.guess + (1 - self.guess - self.lapse) * curve.distribution(z))

    def level_at(self, proportion: float) -> float:
        """Return the level at which a given proportion of answers is correct.

        Raises
        ------
        UserError
            If the proportion lies outside the asymptotes.
        """
        if not self.guess < proportion < 1 - self.lapse:
            raise UserError(
                f"proportion is {proportion:g}, expected between the asymptotes "
                f"{self.guess:.3g} and {1 - self.lapse:.3g}"
            )
        curve = CURVES[self.curve]
        share = (proportion - self.guess) / (1 - self.guess - self.lapse)
        z = curve.inverse(np.array([share, self.share]))
        u = curve.coordinate(self.threshold_level.value) + (z[0] - z[1]) / self.slope_value
        return float(curve.level(u))

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        slope = self.slope
        return {
            "estimator": self.estimator,
            "threshold_level": self.threshold_level.value,
            "threshold_ci": self.threshold_level.interval,
            "slope": slope.value if slope else slope,
            "slope_ci": bounds(slope.interval if slope else None),
            "lapse": self.lapse,
            "guess": self.guess,
            "trials": self.trials,
            Unchanged("levels"): self.levels,
        }
