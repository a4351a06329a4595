"""Estimate a participant's threshold and slope by maximum likelihood or from a posterior.

For definitions and measured performance, see ``docs/explanation/thresholds.md``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.preprocessing.sufficiency import few
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics import psychometric_fit as likelihood
from slipscale.analysis.statistics.psychometrics.posterior import marginals
from slipscale.analysis.statistics.psychometrics.psychometric_fit import Array, Counts, Model
from slipscale.analysis.statistics.psychometrics.psychometric_function import (
    METHODS,
    Answers,
    Estimate,
    PsychometricFunction,
    estimate,
)
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES
from slipscale.faults import UserError

#: Upper bound of the lapse rate (Wichmann and Hill 2001, Percept. Psychophys. 63, 1293-1313).
LARGEST_LAPSE = 0.06
#: Drops in log likelihood below this value are negligible.
NO_LESS_LIKELY = 1e-3
#: A slope is undetermined if its upper confidence limit is more than this many times the lower one.
WIDEST = 20.0


def fit_threshold(
    answers: Answers,
    *,
    method: str = "two_interval",
    curve: str = "weibull",
    share: float = 0.5,
    largest_lapse: float = LARGEST_LAPSE,
    confidence: float = 0.95,
) -> PsychometricFunction | NotComputed:
    """Fit a psychometric function by maximum likelihood, with profile-likelihood intervals.

    Parameters
    ----------
    method, curve : str
        Keys of `METHODS` and `CURVES`, respectively.
    share : float
        Value of the curve at the threshold, without guesses and lapses. A share of 0.5 is halfway
        between the asymptotes (75 % correct with two intervals and no lapses).
    largest_lapse : float
        Upper bound of the lapse rate. If 0, the model contains no lapses.

    Raises
    ------
    UserError
        If the method or curve is unknown, or if an argument is out of range.
    """
    model = model_of(method, curve, share, largest_lapse)
    found = _likeliest(answers, model)
    if isinstance(found, NotComputed):
        return found
    counts, theta = counts_of(answers, model), found.theta[0]
    drop = _half_chi_square(confidence)
    (low,), (high,) = likelihood.profile(model, counts, found, likelihood.THRESHOLD, drop=drop)
    (shallow,), (steepest,) = likelihood.profile(
        model, counts, found, likelihood.LOG_SLOPE, drop=drop
    )
    slope_value = float(np.exp(theta[likelihood.LOG_SLOPE]))
    equal = model.guess == "equal to lapse"
    return PsychometricFunction(
        estimator="maximum likelihood",
        curve=curve,
        method=method,
        share=share,
        threshold_level=estimate(
            model.curve.level([theta[likelihood.THRESHOLD], low, high]), confidence
        ),
        slope=NotComputed("the answers jump between two levels, so the best slope is infinite")
        if model.guess == "fixed" and _jumps(model, counts, found)[0]  # others were refused
        else _slope(np.exp([theta[likelihood.LOG_SLOPE], shallow, steepest]), answers, confidence),
        slope_value=slope_value,
        lapse=float(theta[likelihood.LAPSE]),
        guess=float(theta[likelihood.LAPSE if equal else likelihood.GUESS]),
        trials=int(answers.trials.sum()),
        levels=len(answers.levels),
    )


def threshold_values(
    people: Sequence[Answers],
    *,
    method: str,
    curve: str,
    share: float = 0.5,
    half_width: bool = False,
) -> Array:
    """Return the thresholds of many people in µm peak to peak, as fitted by `fit_threshold`.

    Intervals are not computed, so thousands of thresholds take only about a second. The same rules
    decide who has a threshold.

    Parameters
    ----------
    share : float
        Value of the curve at the threshold; see `fit_threshold`.
    half_width : bool
        Whether to return half the distance between the curve's 25 % and 75 % points instead of the
        threshold. A curve of the logarithm of the amplitude has none.

    Returns
    -------
    array, shape (people,)
        NaN for people without a threshold.
    """
    model = model_of(method, curve, share, LARGEST_LAPSE)
    found = np.full(len(people), np.nan)
    enough = [place for place, each in enumerate(people) if not _too_little(each, model)]
    if not enough or (half_width and model.curve.logarithmic):
        return found
    counts = side_by_side([counts_of(people[place], model) for place in enough])
    fits = likelihood.fit(model, counts)
    theta = fits.theta
    low, high = fits.at_bound(likelihood.THRESHOLD)
    none = fits.at_bound(likelihood.LOG_SLOPE)[0] | low | high
    values = model.curve.level(theta[:, likelihood.THRESHOLD])
    ends = zip(values, (people[place].levels for place in enough), strict=True)
    none |= np.array([_beyond(float(value), levels) is not None for value, levels in ends])
    if model.guess != "fixed":
        none |= _jumps(model, counts, fits)
    if half_width:
        quarter, three = model.curve.inverse(np.array([0.25, 0.75]))
        values = float(three - quarter) / 2 / np.exp(theta[:, likelihood.LOG_SLOPE])
    found[enough] = np.where(none, np.nan, values)
    return found


def side_by_side(sets: Sequence[Counts]) -> Counts:
    """Combine data sets into one array with a row per data set.

    Data sets with fewer levels are padded with copies of their last level, which have no trials.
    """
    longest = max(each.u.shape[1] for each in sets)

    def padded(values: Array, *, repeat: bool) -> Array:
        more = longest - values.shape[1]
        return np.pad(values, ((0, 0), (0, more)), mode="edge" if repeat else "constant")

    return Counts(
        np.concatenate([padded(each.u, repeat=True) for each in sets]),
        np.concatenate([padded(each.correct, repeat=False) for each in sets]),
        np.concatenate([padded(each.trials, repeat=False) for each in sets]),
    )


def fit_threshold_by_posterior(
    answers: Answers,
    *,
    method: str = "two_interval",
    curve: str = "weibull",
    share: float = 0.5,
    confidence: float = 0.95,
) -> PsychometricFunction | NotComputed:
    """Fit a psychometric function using posterior medians and equal-tailed credible intervals.

    For the priors, see `slipscale.analysis.statistics.psychometrics.posterior`. Parameters and
    errors are described in `fit_threshold`. If `fit_threshold` finds no threshold, its reason is
    returned. The median may lie beyond the levels presented; the report then calls it extrapolated.
    """
    model = model_of(method, curve, share, LARGEST_LAPSE)
    likeliest = _likeliest(answers, model)
    if isinstance(likeliest, NotComputed):
        return likeliest
    found = marginals(model, counts_of(answers, model), confidence)
    ends = np.exp(found.log_slope)
    return PsychometricFunction(
        estimator="posterior",
        curve=curve,
        method=method,
        share=share,
        threshold_level=estimate(model.curve.level(found.threshold), confidence),
        slope=_slope(ends, answers, confidence),
        slope_value=float(ends[0]),
        lapse=found.lapse,
        guess=found.lapse if model.guess == "equal to lapse" else found.guess,
        trials=int(answers.trials.sum()),
        levels=len(answers.levels),
    )


def model_of(method: str, curve: str, share: float, largest_lapse: float) -> Model:
    """Return the model to fit, or raise `UserError` if an argument is invalid."""
    if method not in METHODS:
        raise UserError(f"method is {method!r}, expected one of {', '.join(METHODS)}")
    if curve not in CURVES:
        raise UserError(f"curve is {curve!r}, expected one of {', '.join(CURVES)}")
    if not 0 < share < 1:
        raise UserError(f"share is {share:g}, expected between 0 and 1")
    if not 0 <= largest_lapse < 0.5:  # noqa: PLR2004 - half of the answers
        raise UserError(f"largest_lapse is {largest_lapse:g}, expected 0 or more and below 0.5")
    kind = METHODS[method]
    return Model(
        curve=CURVES[curve],
        share=share,
        guess=kind.guess,
        guess_rate=kind.guess_rate,
        largest_lapse=largest_lapse,
    )


def counts_of(answers: Answers, model: Model) -> Counts:
    """Convert answers to a single data set for `psychometric_fit`."""
    u = likelihood.coordinates(model.curve, answers.levels)
    return Counts(u[None], answers.correct[None], answers.trials[None])


def _likeliest(answers: Answers, model: Model) -> likelihood.Fits | NotComputed:
    if why := _too_little(answers, model):
        return NotComputed(why)
    found = likelihood.fit(model, counts_of(answers, model))
    if found.at_bound(likelihood.LOG_SLOPE)[0][0]:
        return NotComputed("answers do not improve as the level rises")
    if any(at[0] for at in found.at_bound(likelihood.THRESHOLD)):
        return NotComputed("the most likely threshold is far outside the levels presented")
    if why := _not_presented(answers, model, found):
        return NotComputed(why)
    return found


def _not_presented(answers: Answers, model: Model, found: likelihood.Fits) -> str | None:
    """Return the reason if the threshold lies where nothing was presented, otherwise None."""
    levels = answers.levels
    threshold = float(model.curve.level(found.theta[0][likelihood.THRESHOLD]))
    if why := _beyond(threshold, levels):
        return why
    # The guess rate of a forced choice is known, so its answers at chance place the threshold.
    if model.guess == "fixed" or not _jumps(model, counts_of(answers, model), found)[0]:
        return None
    above = int(np.searchsorted(levels, threshold))
    return (
        f"the answers change between {levels[above - 1]:g} and {levels[above]:g}, where nothing "
        "was presented"
    )


def _beyond(threshold: float, levels: Array) -> str | None:
    """Return the reason if a threshold lies beyond the levels presented, otherwise None."""
    if threshold > levels[-1]:
        return f"the threshold is above {levels[-1]:g}, the highest level presented"
    if threshold < levels[0]:
        return f"the threshold is below {levels[0]:g}, the lowest level presented"
    return None


def _too_little(answers: Answers, model: Model) -> str | None:
    if model.curve.logarithmic and len(answers.levels) and answers.levels[0] < 0:
        raise UserError(
            f"a level is {answers.levels[0]:g}, expected 0 or more for a {model.curve.title}"
        )
    apart = int((model.curve.coordinate(answers.levels) > likelihood.FAR_BELOW).sum())
    if apart < 2:  # noqa: PLR2004 - a curve rises between two levels
        return few("levels above 0" if model.curve.logarithmic else "levels", apart, 2)
    if answers.correct.sum() in {0, answers.trials.sum()}:
        return "all answers are the same, so no curve can be fitted"
    return None


def _slope(value_and_ends: Array, answers: Answers, confidence: float) -> Estimate | NotComputed:
    """Return the slope, or a reason if its interval shows that the answers do not determine it."""
    value, low, high = value_and_ends
    if not low < value < high or high > WIDEST * low:
        return NotComputed(f"{answers.trials.sum():.0f} trials do not determine the slope")
    return estimate(value_and_ends, confidence)


def _jumps(model: Model, counts: Counts, found: likelihood.Fits) -> NDArray[np.bool_]:
    """Return which data sets the steepest allowed slope fits about as well as the best slope."""
    steepest = likelihood.Bounds(found.bounds.low.copy(), found.bounds.high)
    steepest.low[:, likelihood.LOG_SLOPE] = found.bounds.high[:, likelihood.LOG_SLOPE]
    held = likelihood.fit(model, counts, steepest)
    return np.asarray(found.log_likelihood - held.log_likelihood < NO_LESS_LIKELY)


def _half_chi_square(confidence: float) -> float:
    from scipy import stats

    return float(stats.chi2.ppf(confidence, 1)) / 2
