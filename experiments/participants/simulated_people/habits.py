"""Response habits of simulated people, each with one parameter and off by default.

The description of each response habit names an analysis that can detect the habit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from slipscale.faults.frozen_table import setting

Share = Annotated[float, Field(ge=0, le=1)]
# Time constant with which a moist contact approaches its final friction (Dzidek et al. 2017, PLoS
# ONE 12, e0188000: occlusion moistens the skin within about 20 s).
SETTLING_S = 20.0
ROUND_TO_PERCENT = 5.0
LEAST_PERCENT = 0.5  # lower limit of sensations in logarithms and ratios


class Habits(BaseModel):
    """Response habits. A value of 0 turns a habit off."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    rounding: Share = setting(
        0.0,
        "Proportion of estimates that are rounded to a multiple of 5 % of the scale. According to "
        "Honda 2022, Scientific Reports 12, multiples of 5 and 10 are most frequent. Rounding is "
        "visible in the proportion of round estimates.",
        realistic=0.7,
    )
    carry_over: Annotated[float, Field(ge=-2, le=2)] = setting(
        0.0,
        "Change in the log estimate per µm (peak to peak) of the previous surface: values above "
        "0 mean assimilation. Carry-over was reported by Jesteadt, Luce and Green 1977, Journal of "
        "Experimental Psychology: Human Perception and Performance 3, 92-104; the value in the "
        "realistic population is our assumption. Carry-over is visible as "
        "log_slope_per_um_pp_before in the analysis result `order`.",
        realistic=0.03,
        unit="1/µm",
    )
    lapses: Share = setting(
        0.0,
        "Proportion of questions that are answered at random. Wichmann and Hill 2001, "
        "Perception & Psychophysics 63, 1293-1313, report 0 to 5 %. Lapses are visible as "
        "false alarms in catch steps.",
        realistic=0.02,
    )
    regression: Share = setting(
        0.0,
        "Fraction by which log estimates shrink towards the mean log sensation of all trials so "
        "far. Source: Poulton 1979, Psychological Bulletin 86, 777-803. Regression is visible as "
        "a smaller exponent of the estimates.",
        realistic=0.1,
    )
    range_effect: Share = setting(
        0.0,
        "Degree to which people use their whole scale regardless of the range of levels; at 1, "
        "log estimates have the same spread for every range. According to Teghtsoonian 1971, "
        "Perception & Psychophysics 10, 147-155, exponents decrease with the range. The range "
        "effect is visible as a larger exponent for a smaller range.",
        realistic=0.1,
    )
    learning: Share = setting(
        0.0,
        "Exponent of the power law by which trial-to-trial noise decreases with the trial number. "
        "Our assumption. Learning is visible as larger residuals in the first half of the trials "
        "than in the second half.",
        realistic=0.1,
    )
    fatigue: Annotated[float, Field(ge=0, le=0.1)] = setting(
        0.0,
        "Decrease of the log estimate per trial. Our assumption. Fatigue is visible as a negative "
        "log_slope_per_trial in the analysis result `order`.",
        realistic=0.002,
        unit="1/trial",
    )
    settling: Share = setting(
        0.0,
        "Fraction of the sensation that is missing at first touch and builds up during contact "
        "with a time constant of 20 s. After a rest, the sensation builds up again from the "
        "beginning. The time constant is from Dzidek 2017, PLoS ONE 12, e0188000; the value in the "
        "realistic population is our assumption. Settling is visible as a positive "
        "log_slope_per_trial in the analysis result `order`.",
        realistic=0.1,
    )
    interval_bias: Annotated[float, Field(ge=-3, le=3)] = setting(
        0.0,
        "Bias towards the last interval of a comparison, in units of the noise in judging a "
        "difference. Interval bias was reported by García-Pérez and Alcalá-Quintana 2011, "
        "Frontiers in Psychology 2, 96; the value in the realistic population is our assumption. "
        "Interval bias is visible in the proportion of answers that choose the last interval.",
        realistic=0.2,
        unit="d'",
    )
    anchoring: Share = setting(
        0.0,
        "Distance between a mark and the intended rating, as a fraction of the distance between "
        "the mark's start position and the intended rating. Anchoring was described by Tversky and "
        "Kahneman 1974, Science 185, 1124-1131; the value in the realistic population is our "
        "assumption. Anchoring is visible as "
        "start_effect in the analysis result `ratings`.",
        realistic=0.05,
    )
    misread: Share = setting(
        0.0,
        "Proportion of people who rate how sticky a surface is instead of how slippery. Our "
        "assumption. Misreading the question is visible in the quality flag non_monotone.",
        realistic=0.02,
    )
    dropout: Share = setting(
        0.0,
        "Proportion of people who stop before the end; every trial is equally likely to be the "
        "last. Our assumption. Dropout is visible as incomplete runs.",
        realistic=0.03,
    )


REALISTIC = Habits(
    **{
        name: field.json_schema_extra["realistic"]
        for name, field in Habits.model_fields.items()
        if isinstance(field.json_schema_extra, dict)
    }
)

#: One person's value, or the values of many people.
Numbers = float | NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class History:
    """Summary of a person's sensations in a task up to this trial.

    If the fields are arrays, they describe many people at once.

    Parameters
    ----------
    trials : int
        Number of trials so far, including this one.
    log_sum, log_least, log_largest : float or array
        Sum, minimum and maximum of the log of the population's mean sensation at the presented
        levels.
    before_level : float or array
        Level of the previous surface in µm peak to peak. Not used in the first trial.
    contact_s : float or array
        Contact time of the finger with the plate since the last rest.
    """

    trials: int = 0
    log_sum: Numbers = 0.0
    log_least: Numbers = math.inf
    log_largest: Numbers = -math.inf
    before_level: Numbers = 0.0
    contact_s: Numbers = 0.0

    def with_trial(self, log_sensation: Numbers, before_level: Numbers) -> History:
        """Return a copy of the history with one more trial."""
        return History(
            trials=self.trials + 1,
            log_sum=self.log_sum + log_sensation,
            log_least=np.minimum(self.log_least, log_sensation),
            log_largest=np.maximum(self.log_largest, log_sensation),
            before_level=before_level,
            contact_s=self.contact_s,
        )

    def after_contact(self, contact_s: Numbers) -> History:
        """Return a copy of the history with the given contact time."""
        return replace(self, contact_s=contact_s)


@dataclass(frozen=True, slots=True)
class Frame:
    """Reference values for computing the effects of habits in one population.

    Parameters
    ----------
    log_range : float
        Logarithm of the ratio of the largest to the smallest mean sensation.
    middle_level : float
        Middle of the range of amplitudes, µm peak to peak. A previous surface at this amplitude
        causes no carry-over.
    """

    log_range: float
    middle_level: float


def reported(percent: Numbers, habits: Habits, past: History, frame: Frame) -> Numbers:
    """Return sensations (0-100) after applying the response habits in `DISTORTING`.

    Parameters
    ----------
    percent : float or array
        Sensations without response habits.
    past : History
        Summary of the sensations of these people so far, including the current trial.
    """
    log = np.log(np.maximum(percent, LEAST_PERCENT))
    if habits.regression or habits.range_effect:
        centre = past.log_sum / past.trials
        span = past.log_largest - past.log_least
        wide = span > LEAST_LOG_RANGE
        stretch = np.where(wide, frame.log_range / np.where(wide, span, 1.0), 1.0)
        log = centre + (1 - habits.regression) * stretch**habits.range_effect * (log - centre)
    if habits.carry_over and past.trials > 1:
        log = log + habits.carry_over * (past.before_level - frame.middle_level)
    log = log - habits.fatigue * (past.trials - 1)
    return np.exp(log) * (1 - habits.settling * np.exp(-past.contact_s / SETTLING_S))


def distorts(habits: Habits) -> bool:
    """Return whether any habit changes the sensations that a person reports (see `reported`)."""
    return any(getattr(habits, name) for name in DISTORTING)


DISTORTING = ("carry_over", "regression", "range_effect", "fatigue", "settling")
# The range effect is zero if the mean sensations of the presented levels differ by less than 5 %.
LEAST_LOG_RANGE = 0.05
