"""Relate ratings to the friction measured in the same trials.

If a study measures normal and lateral force, the logarithm of the estimate is regressed on the
coefficient of friction, separately for each participant. Slopes and correlations are then averaged
across participants, because trials of the same person are not independent and because skin differs
between people.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.preprocessing.sufficiency import TINY
from slipscale.analysis.statistics.arrays import Array
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    mean_over_participants,
)
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.experiments.dataset.measured import COEFFICIENT
from slipscale.experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.preprocessing.log_transform import Prepared

FEWEST_TRIALS = 4  # Fisher's interval is not defined for fewer points
# Fisher's z is infinite for a perfect correlation.
LARGEST_CORRELATION = 1 - 1e-12


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticipantLine:
    """The regression line of one participant's log estimates on friction.

    Parameters
    ----------
    participant_id : str
    trials : int
        Number of trials with an estimate above 0 and a measured coefficient of friction.
    slope : float
        Change in the natural logarithm of the estimate per unit of the coefficient of friction.
    slope_interval : ConfidenceInterval
        t-based least-squares interval for the slope, assuming independent trials.
    correlation : float
        Pearson correlation between the logarithm of the estimate and the coefficient of friction.
    correlation_interval : ConfidenceInterval
        Interval for the correlation from Fisher's z, assuming independent trials.
    """

    participant_id: str
    trials: int
    slope: float
    slope_interval: ConfidenceInterval
    correlation: float
    correlation_interval: ConfidenceInterval


@dataclass(frozen=True, slots=True, kw_only=True)
class MeanCorrelation:
    """Mean correlation across participants, computed from the mean of Fisher's z.

    Parameters
    ----------
    correlation : float
    interval : ConfidenceInterval
        t-based interval for the mean of Fisher's z, transformed back to a correlation.
    """

    correlation: float
    interval: ConfidenceInterval


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredFriction:
    """The relation between ratings and measured friction.

    Parameters
    ----------
    trials : int
        Number of trials used.
    participants : tuple of ParticipantLine
        Regression lines, one per participant who was not excluded.
    left_out : tuple of str
        Participants who were excluded because they had too few trials, or because friction or
        estimates did not vary.
    slope : MeanOverParticipants or NotComputed
        Mean of participants' slopes.
    correlation : MeanCorrelation or NotComputed
        Mean of participants' correlations.
    """

    trials: int
    participants: tuple[ParticipantLine, ...]
    left_out: tuple[str, ...]
    slope: MeanOverParticipants | NotComputed
    correlation: MeanCorrelation | NotComputed


def used_trials(prepared: Prepared) -> pd.DataFrame:
    """Return the trials with a log estimate and a measured coefficient of friction."""
    trials = prepared.trials
    if prepared.refused or COEFFICIENT not in trials:
        return trials.iloc[:0]
    return trials[trials["log"].notna() & trials[COEFFICIENT].notna()]


def measured_friction(prepared: Prepared | None) -> MeasuredFriction | None:
    """Relate ratings to measured friction, or return None if friction was not measured."""
    if prepared is None or COEFFICIENT not in prepared.trials:
        return None
    if not prepared.trials[COEFFICIENT].notna().any():
        return None
    confidence = prepared.choices.confidence
    trials = used_trials(prepared)
    lines: list[ParticipantLine] = []
    left_out: list[str] = []
    for who, own in trials.groupby(PARTICIPANT, observed=True):
        friction, logs = own[COEFFICIENT].to_numpy(float), own["log"].to_numpy(float)
        if len(own) < FEWEST_TRIALS or _same(friction) or _same(logs):
            left_out.append(str(who))
        else:
            lines.append(_line(str(who), friction, logs, confidence))
    return MeasuredFriction(
        trials=len(trials),
        participants=tuple(lines),
        left_out=tuple(left_out),
        slope=mean_over_participants(np.array([line.slope for line in lines]), confidence),
        correlation=_mean_correlation([line.correlation for line in lines], confidence),
    )


def _same(values: Array) -> bool:
    return bool(np.ptp(values) <= TINY * max(float(np.abs(values).max()), 1.0))


def _line(who: str, friction: Array, logs: Array, confidence: float) -> ParticipantLine:
    from scipy import stats

    found = stats.linregress(friction, logs)
    half = stats.t.ppf((1 + confidence) / 2, len(logs) - 2) * found.stderr
    correlation = float(found.rvalue)
    z, margin = _z(correlation), stats.norm.ppf((1 + confidence) / 2) / math.sqrt(len(logs) - 3)
    return ParticipantLine(
        participant_id=who,
        trials=len(logs),
        slope=float(found.slope),
        slope_interval=ConfidenceInterval(
            float(found.slope - half), float(found.slope + half), confidence
        ),
        correlation=correlation,
        correlation_interval=ConfidenceInterval(
            math.tanh(z - margin), math.tanh(z + margin), confidence
        ),
    )


def _z(correlation: float) -> float:
    return math.atanh(max(min(correlation, LARGEST_CORRELATION), -LARGEST_CORRELATION))


def _mean_correlation(
    correlations: list[float], confidence: float
) -> MeanCorrelation | NotComputed:
    found = mean_over_participants(np.array([_z(each) for each in correlations]), confidence)
    if isinstance(found, NotComputed):
        return found
    return MeanCorrelation(
        correlation=math.tanh(found.mean),
        interval=ConfidenceInterval(
            math.tanh(found.interval.low), math.tanh(found.interval.high), confidence
        ),
    )
