"""Fit a population curve of "yes" against step size.

The step size is the reduction in amplitude, in µm peak to peak or as a Weber fraction.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from slipscale.analysis.json_form import OurName, renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY, few, few_degrees
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.study.analysis_choices import Axis
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

Measure = Literal["removed_level", "weber_fraction"]
#: Intercept and slope of the curve.
COEFFICIENTS = 2
#: Log odds of 90 % "yes".
NEARLY_ALL = float(np.log(9))
#: Size that replaces 0 on a logarithmic axis in figures, relative to the largest.
NEARLY_NONE = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class PsychometricCurve:
    """A logistic curve of "yes" against step size.

    Parameters
    ----------
    measure : {"removed_level", "weber_fraction"}
        Measure of step size: µm peak to peak, or a fraction of the amplitude before the step.
    axis : {"linear", "logarithmic"}
        Whether log odds are linear in the step size, or in its natural logarithm. Steps of 0 have
        no logarithm and are omitted.
    log_odds_per_unit, se : float
        Slope per unit of step size (or of its logarithm), and its standard error.
    interval : ConfidenceInterval
        t-based interval for the slope.
    t, df, p : float, int, float
        t test of the slope against 0.
    intercept : float
        Log odds of "yes" for a step of size 0 (or of 1, on a logarithmic axis).
    covariance : array-like, shape (2, 2)
        Covariance matrix of intercept and slope.
    half_yes : float or None
        Step size with 50 % "yes" answers; None if the curve does not rise, or if the size lies in
        a gap.
    half_yes_interval : ConfidenceInterval or None
        Interval for ``half_yes`` by Fieller's theorem. None if the slope is not significantly above
        0, because the interval is then unbounded, or without ``half_yes``.
    half_yes_between : tuple of float or None
        The two neighbouring step sizes between which the curve rises from below 10 % to above 90 %
        "yes", so that 50 % lies where nothing was presented; None if no such gap exists.
    correlation : float
        Correlation between answers of the same participant.
    n, answers : int
        Counts of participants and of answered steps.
    own_z : Mapping
        z of the slope of each participant's own logistic curve, if ``df`` is small;
        without participants whose answers have no finite slope.
    """

    measure: Measure
    axis: Axis
    log_odds_per_unit: float
    se: float
    interval: ConfidenceInterval
    t: float
    df: int
    p: float
    intercept: float
    covariance: tuple[tuple[float, float], tuple[float, float]]
    half_yes: float | None
    half_yes_interval: ConfidenceInterval | None
    half_yes_between: tuple[float, float] | None
    correlation: float
    n: int
    answers: int
    own_z: Mapping[str, float]

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        names = {"interval": "ci", "half_yes_interval": "half_yes_ci"}
        if self.measure == "removed_level":
            names |= {"log_odds_per_unit": "log_odds_per_level", "half_yes": "half_yes_level"}
        return renamed(self, **names) | {"measure": OurName(self.measure)}


def psychometric(
    steps: pd.DataFrame,
    confidence: float = 0.95,
    measure: Measure = "removed_level",
    quantity: Quantity = PLATE_AMPLITUDE,
    axis: Axis = "linear",
) -> PsychometricCurve | NotComputed:
    """Fit a logistic curve of "yes" answers against step size, with catch steps at 0.

    The fit uses generalised estimating equations from statsmodels (Liang and Zeger 1986, Biometrika
    73, 13-22), with an exchangeable correlation within participants. Standard errors are corrected
    for small samples (Mancl and DeRouen 2001, Biometrics 57, 126-134). The interval uses the t
    distribution with n - 2 degrees of freedom.

    Parameters
    ----------
    steps : DataFrame
        Answered steps, including catch steps; see
        `slipscale.analysis.reading.dataset.Dataset.differences`.
    measure : {"removed_level", "weber_fraction"}
        Measure of step size. Steps that begin at 0 have no Weber fraction and are omitted.
    quantity : Quantity
        Quantity of the presented stimuli. For the plate's amplitude, Weber fractions are relative
        to the amplitude before the step; for other quantities, they are relative to the reference.
    axis : {"linear", "logarithmic"}
        The default is linear, because catch steps have a size of 0.
    """
    base = "level_before" if quantity.stepped else "level"
    if measure == "weber_fraction":
        steps = steps[steps[base] > 0]
    if not len(steps):
        begins = "step begins at" if quantity.stepped else "reference is"
        return NotComputed(
            f"every {begins} 0, so there is no Weber fraction for the {quantity.name}"
        )
    removed = (steps["level_before"] - steps["level"]).to_numpy(float)
    if measure == "weber_fraction":
        removed = np.abs(removed) / steps[base].to_numpy(float)
    if axis == "logarithmic":
        steps, removed = steps[removed > 0], np.log(removed[removed > 0])
    if not len(steps):
        return NotComputed("no step is above 0, so there is no logarithm")
    felt = steps["difference_felt"].to_numpy(float)
    people = steps[PARTICIPANT].astype(str).to_numpy()
    n = len(np.unique(people))
    if n < FEWEST:
        return NotComputed(few("participants", n))
    if why := separated(removed, felt, quantity):
        return NotComputed(why)
    # The standard error comes from the spread between people. If only one or two of them gave the
    # rarer answer, it is too small: among people who feel all steps alike, up to .46 of slopes
    # were significant (`benchmarks.truths`).
    for answer, word in ((1.0, "yes"), (0.0, "no")):
        who = len(np.unique(people[felt == answer]))
        if who < FEWEST:
            return NotComputed(few(f"participants who answered “{word}”", who))
    frame = pd.DataFrame({"felt": felt, "removed": removed, "who": people})
    return _fit(frame, n, confidence, measure, axis)


def curve(
    found: PsychometricCurve, removed: NDArray[np.float64], confidence: float = 0.95
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the fitted proportion of "yes" answers and its pointwise t-based confidence band.

    Parameters
    ----------
    found : PsychometricCurve
        Result of `psychometric`.
    removed : array, shape (k,)
        Step sizes in µm peak to peak.

    Returns
    -------
    proportion, low, high : array, shape (k,)
        Fitted proportions, and the lower and upper bounds of the confidence band.
    """
    from scipy import special, stats

    if found.axis == "logarithmic":
        removed = np.log(np.maximum(removed, NEARLY_NONE * removed.max()))
    design = np.stack([np.ones_like(removed), removed], axis=1)
    log_odds = design @ [found.intercept, found.log_odds_per_unit]
    variance = ((design @ np.array(found.covariance)) * design).sum(axis=1)
    half = stats.t.ppf((1 + confidence) / 2, found.df) * np.sqrt(variance)
    low, middle, high = (special.expit(log_odds + sign * half) for sign in (-1, 0, 1))
    return middle, low, high


def separated(
    removed: NDArray[np.float64],
    felt: NDArray[np.float64],
    quantity: Quantity = PLATE_AMPLITUDE,
) -> str | None:
    """Return the reason why no finite slope can be fitted, or None if one can.

    >>> separated(np.array([0, 1.0, 2]), np.array([0, 1.0, 1]))[:25]
    'the size of the step sepa'
    """
    yes, no = removed[felt == 1], removed[felt == 0]
    if not len(yes) or not len(no):
        return f"every answer is {'yes' if len(yes) else 'no'}, so no curve can be fitted"
    if np.ptp(removed) == 0:
        return (
            f"there is only one {'step size' if quantity.stepped else 'level'}, but a "
            "curve requires two"
        )
    gap = max(yes.min() - no.max(), no.min() - yes.max()) / np.ptp(removed)
    if gap < -TINY:
        return None
    one = "step size" if quantity.stepped else "level"
    kind = " (complete" if gap > TINY else f", except at one {one} (quasi-complete"
    return (
        f"{quantity.yes_no.size} separates all “yes” from all “no” answers{kind} separation), so "
        "the slope would be infinite"
    )


def _fit(
    frame: pd.DataFrame, n: int, confidence: float, measure: Measure, axis: Axis
) -> PsychometricCurve | NotComputed:
    from scipy import stats
    from statsmodels.genmod import cov_struct, families
    from statsmodels.genmod.generalized_estimating_equations import GEE
    from statsmodels.tools.sm_exceptions import IterationLimitWarning

    model = GEE.from_formula(
        "felt ~ removed",
        "who",
        frame,
        family=families.Binomial(),
        cov_struct=cov_struct.Exchangeable(),
    )
    try:
        # Libraries' warnings are suppressed; a diverging fit is reported as "did not converge".
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore", IterationLimitWarning)
            fit = model.fit(cov_type="bias_reduced")
    except (np.linalg.LinAlgError, ValueError) as error:
        return NotComputed(f"the curve could not be fitted ({error})")
    slope, se = float(fit.params["removed"]), float(fit.bse["removed"])
    if not fit.converged or not np.isfinite([slope, se]).all():
        return NotComputed("the fit did not converge")
    df = n - COEFFICIENTS
    quantile = float(stats.t.ppf((1 + confidence) / 2, df))
    half = quantile * se
    (a, b), (c, d) = fit.cov_params().to_numpy(float).tolist()
    intercept = float(fit.params["Intercept"])
    ends = fieller((intercept, slope), ((a, b), (c, d)), quantile, confidence)
    gap = _gap(np.unique(frame["removed"]), intercept, slope)
    to_size = math.exp if axis == "logarithmic" else float
    return PsychometricCurve(
        measure=measure,
        axis=axis,
        log_odds_per_unit=slope,
        se=se,
        interval=ConfidenceInterval(slope - half, slope + half, confidence),
        t=slope / se,
        df=df,
        p=float(2 * stats.t.sf(abs(slope / se), df)),
        intercept=intercept,
        covariance=((a, b), (c, d)),
        half_yes=to_size(-intercept / slope) if slope > 0 and gap is None else None,
        half_yes_interval=None
        if ends is None or gap is not None
        else ConfidenceInterval(to_size(ends.low), to_size(ends.high), confidence),
        half_yes_between=None if gap is None else (to_size(gap[0]), to_size(gap[1])),
        correlation=float(model.cov_struct.dep_params),
        n=n,
        answers=len(frame),
        own_z=_own_z(frame) if few_degrees(df) else {},
    )


def _own_z(frame: pd.DataFrame) -> dict[str, float]:
    """Return z of the slope of each participant's logistic curve, if the slope is finite."""
    import statsmodels.api as sm

    found = {}
    for who, own in frame.groupby("who"):
        removed, felt = own["removed"].to_numpy(float), own["felt"].to_numpy(float)
        if not separated(removed, felt):
            model = sm.GLM(felt, sm.add_constant(removed), family=sm.families.Binomial())
            found[str(who)] = float(model.fit().tvalues[1])
    return found


def _gap(sizes: NDArray[np.float64], intercept: float, slope: float) -> tuple[float, float] | None:
    """Return the neighbouring sizes between which a curve rises from below 10 % to above 90 %."""
    log_odds = intercept + slope * sizes
    for place in range(len(sizes) - 1):
        if log_odds[place] < -NEARLY_ALL and log_odds[place + 1] > NEARLY_ALL:
            return float(sizes[place]), float(sizes[place + 1])
    return None


def fieller(
    coefficients: tuple[float, float],
    covariance: tuple[tuple[float, float], tuple[float, float]],
    quantile: float,
    confidence: float,
) -> ConfidenceInterval | None:
    """Return an interval for the zero of a + b x, or None if b is not significantly above 0.

    The interval contains all x at which the line differs from 0 by less than ``quantile`` standard
    errors (Fieller 1954, Journal of the Royal Statistical Society B 16, 175-185).

    >>> low, high = fieller((-2.0, 4.0), ((0.04, 0.0), (0.0, 0.0)), 2.0, 0.95)
    >>> round(low, 9), round(high, 9)
    (0.4, 0.6)
    """
    (a, b), ((aa, ab), (_, bb)) = coefficients, covariance
    square = b**2 - quantile**2 * bb
    if b <= 0 or square <= 0:
        return None
    middle = a * b - quantile**2 * ab
    root = float(np.sqrt(max(middle**2 - square * (a**2 - quantile**2 * aa), 0.0)))
    return ConfidenceInterval((-middle - root) / square, (-middle + root) / square, confidence)
