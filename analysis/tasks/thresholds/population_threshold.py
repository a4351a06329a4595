"""What participants' thresholds say of a population, and of a standard."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.preprocessing.sufficiency import FEWEST, few
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.psychometric_function import (
    Estimate,
    PsychometricFunction,
    estimate,
)
from slipscale.experiments.protocols.adaptive.curves import CURVES
from slipscale.faults import UserError

if TYPE_CHECKING:
    from collections.abc import Sequence


def weber_fraction(fitted: PsychometricFunction, standard_um_pp: float) -> Estimate | NotComputed:
    """Return the just noticeable difference as a part of the standard.

    With intervals to choose from, levels are differences from the standard, and the threshold is
    the difference; in a comparison, levels are amplitudes, and it is half the distance between
    25 and 75 % of the curve.

    Raises
    ------
    UserError
        The standard is not above 0, or the method does not compare with one.
    """
    if not (np.isfinite(standard_um_pp) and standard_um_pp > 0):
        raise UserError(f"standard_um_pp is {standard_um_pp:g}, expected above 0")
    if fitted.method == "yes_no":
        raise UserError("a Weber fraction needs a standard; yes_no asks for none")
    if fitted.method != "comparison":
        found = fitted.threshold_um_pp
        relative = np.array([found.value, *found.interval]) / standard_um_pp
        return estimate(relative, found.interval.confidence)
    family = CURVES[fitted.curve]
    if family.logarithmic:
        raise UserError("a comparison's Weber fraction needs a curve of the amplitude itself")
    if isinstance(fitted.slope, NotComputed):
        return fitted.slope
    low, high = family.inverse(np.array([0.25, 0.75]))
    scale = float(high - low) / 2 / standard_um_pp
    shallow, steep = fitted.slope.interval
    with np.errstate(divide="ignore"):
        relative = scale / np.array([fitted.slope.value, steep, shallow])
    return estimate(relative, fitted.slope.interval.confidence)


@dataclass(frozen=True, slots=True, kw_only=True)
class PopulationThreshold:
    """The threshold of a population, from its participants'.

    Parameters
    ----------
    threshold_um_pp : Estimate
        Mean of the participants', geometric on a logarithmic curve, with Student's interval.
    sd : float
        Between participants: decades on a logarithmic curve, µm peak to peak on others.
    n : int
        Participants with a threshold.
    left_out : int
        Participants without one.
    """

    threshold_um_pp: Estimate
    sd: float
    n: int
    left_out: int


def population_threshold(
    fits: Sequence[PsychometricFunction | NotComputed], confidence: float = 0.95
) -> PopulationThreshold | NotComputed:
    """Return the population's threshold, every participant counting as one.

    Raises
    ------
    UserError
        The fits are of several curves or thresholds.
    """
    from scipy import stats  # noqa: PLC0415 - half a second's import

    there = [one for one in fits if one]
    if len({(one.curve, one.share, one.method) for one in there}) > 1:
        raise UserError("a population's threshold needs one curve, method and share of it for all")
    if len(there) < FEWEST:
        return NotComputed(few("participants with a threshold", len(there)))
    family = CURVES[there[0].curve]
    values = family.coordinate([one.threshold_um_pp.value for one in there])
    mean, sd = float(values.mean()), float(values.std(ddof=1))
    half = float(stats.t.ppf((1 + confidence) / 2, len(values) - 1)) * sd / len(values) ** 0.5
    return PopulationThreshold(
        threshold_um_pp=estimate(family.level([mean, mean - half, mean + half]), confidence),
        sd=sd / float(np.log(10)) if family.logarithmic else sd,
        n=len(there),
        left_out=len(fits) - len(there),
    )
