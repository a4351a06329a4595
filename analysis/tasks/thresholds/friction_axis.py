"""Estimate thresholds and just noticeable differences in measured friction.

Friction depends on the plate's amplitude and on the finger. If normal and lateral force were
measured in each interval, the answers are also fitted against friction. In these fits, the level of
a trial is the change in friction: the mean coefficient in the intervals without the target minus
the coefficient in the interval with the target. If friction increases with the plate's level, the
sign is reversed, so that curves rise. Trials without a measurement in the target's interval, or
without any measurement in the other intervals, are omitted and counted.

Noise in single measurements flattens a curve and makes the just noticeable difference too large
(Carroll et al. 2006, Measurement Error in Nonlinear Models). By default, a participant's changes in
friction are averaged by plate level, session and condition. Changes in single trials are rounded to
`STEP` standard deviations, because fits with many different levels are slow. Changes can be 0 or
negative, so a logarithmic curve is replaced with the same curve on a linear axis.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from slipscale.analysis.reading.trial_tables import FACTOR
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.psychometric_function import Estimate
from slipscale.analysis.tasks.thresholds.population_threshold import over, population_threshold
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES, OTHER_AXIS
from slipscale.experiments.study.analysis_choices import AnalysisChoices

STEP = 0.1
#: Columns for the coefficient measured in the interval with the target, and for its mean in the
#: other intervals.
TARGET_FRICTION, OTHER_FRICTION = "target_friction", "other_friction"


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionThreshold:
    """The population threshold, expressed as a change in measured friction.

    Parameters
    ----------
    lower : bool
        Whether a positive change is a reduction in friction.
    averaged : bool
        Whether changes were averaged per participant and plate level instead of taken from single
        trials.
    change : Estimate
        Change in the coefficient of friction at the threshold or, for a comparison, at the point of
        subjective equality.
    just_noticeable : Estimate or NotComputed
        Just noticeable difference in the coefficient of friction. For a comparison, half the
        distance between the 25 % and 75 % points; otherwise, equal to ``change``.
    weber_fraction : Estimate or NotComputed
        ``just_noticeable`` divided by ``standard``.
    standard : float
        Mean coefficient of friction in the intervals without the target.
    sd : float
        Standard deviation of the change at threshold across participants.
    scatter : float
        Standard deviation of single-trial changes around the mean per participant and plate level.
    participants : Mapping of str to float
        Change in the coefficient of friction at each participant's threshold, shrunk towards the
        population mean.
    n, answers, left_out : int
        Counts of participants, of answers, and of trials without a measurement.
    """

    lower: bool
    averaged: bool
    change: Estimate
    just_noticeable: Estimate | NotComputed
    weber_fraction: Estimate | NotComputed
    standard: float
    sd: float
    scatter: float
    participants: Mapping[str, float]
    n: int
    answers: int
    left_out: int


def friction_threshold(
    rows: pd.DataFrame, choices: AnalysisChoices, *, method: str, curve: str
) -> FrictionThreshold | NotComputed:
    """Fit all participants' answers in one task against measured friction.

    Parameters
    ----------
    rows : DataFrame
        Trials of the task from `slipscale.analysis.tasks.thresholds.reading.read_choices`.
    method, curve : str
        Method and curve of the fit against the plate's level.
    """
    if choices.threshold_friction is None:
        return NotComputed("the study file does not set threshold_friction")
    change = rows[OTHER_FRICTION] - rows[TARGET_FRICTION]
    caught, known = rows["catch"], change.notna()
    if not (known & ~caught).any():
        return NotComputed(
            "in no trial was friction measured for the target and for another surface"
        )
    main = rows[known & ~caught]
    change = change[main.index]
    level = main["track_level"]
    rises = float(((level - level.mean()) * change).sum())
    change = change if rises >= 0 else -change
    conditions = [name for name in rows if str(name).startswith(FACTOR)]
    by = [main[name] for name in (PARTICIPANT, "session", *conditions, "track_level")]
    means = change.groupby(by, observed=True, dropna=False).transform("mean")
    averaged = choices.threshold_friction == "level_means"
    linear = OTHER_AXIS[curve] if CURVES[curve].logarithmic else curve
    levels = rows["track_level"].where(caught)  # only lapses miss catch trials
    step = STEP * float(change.std()) or 1.0
    levels.update(means if averaged else (change / step).round() * step)
    measured = rows.assign(track_level=levels)[known | caught]
    found = population_threshold(measured, choices, method=method, curve=linear)
    if isinstance(found, NotComputed):
        return found
    just = found.half_width_level if method == "comparison" else found.threshold_level
    standard = float(main[OTHER_FRICTION].mean())
    cells = len(means.groupby(by, observed=True, dropna=False).size())
    spare = len(main) - cells
    return FrictionThreshold(
        lower=rises >= 0,
        averaged=averaged,
        change=found.threshold_level,
        just_noticeable=just,
        weber_fraction=over(just, standard) if just else just,
        standard=standard,
        sd=found.sd,
        scatter=float((((change - means) ** 2).sum() / spare) ** 0.5) if spare else float("nan"),
        participants=found.participants,
        n=found.n,
        answers=found.answers,
        left_out=int((~known & ~caught).sum()),
    )
