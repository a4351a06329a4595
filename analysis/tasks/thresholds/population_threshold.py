"""Estimate a population's threshold and Weber fraction from participants' answers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations

import numpy as np
import pandas as pd

from slipscale.analysis.json_form import Unchanged, renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, few
from slipscale.analysis.reading.surface_labels import numbers_first
from slipscale.analysis.reading.trial_tables import FACTOR, factor_columns
from slipscale.analysis.statistics.holm import holm
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics import psychometric_fit as likelihood
from slipscale.analysis.statistics.psychometrics.hierarchical import HierarchicalFit, Trials
from slipscale.analysis.statistics.psychometrics.psychometric_fit import Array, Model
from slipscale.analysis.statistics.psychometrics.psychometric_function import (
    METHODS,
    Estimate,
    PsychometricFunction,
    estimate,
)
from slipscale.analysis.statistics.psychometrics.thresholds import model_of
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES, OTHER_AXIS, Curve
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.faults import UserError

#: Difference in log likelihood above which a curve is clearly better (a difference of 4 in AIC).
CLEARLY = 2.0
#: Two levels do not determine a threshold, a slope and a lapse rate.
FEWEST_LEVELS = 3
#: Separator between the names of combined factors, and between their labels.
COMBINED = ", "


def weber_fraction(fitted: PsychometricFunction, standard_level: float) -> Estimate | NotComputed:
    """Return the just noticeable difference as a fraction of the standard.

    In a forced choice between intervals, levels are differences from the standard, and the just
    noticeable difference is the threshold. In a comparison, levels are amplitudes, and the just
    noticeable difference is half the distance between the 25 % and 75 % points on the curve.

    Raises
    ------
    UserError
        The standard is not above 0, or the method has no standard.
    """
    if not (np.isfinite(standard_level) and standard_level > 0):
        raise UserError(
            "standard_level is {standard_level:g}, expected above 0", standard_level=standard_level
        )
    if fitted.method == "yes_no":
        raise UserError("a Weber fraction requires a standard, but yes_no trials have no standard")
    if fitted.method != "comparison":
        return over(fitted.threshold_level, standard_level)
    if isinstance(fitted.slope, NotComputed):
        return fitted.slope
    middle = fitted.threshold_level.value
    return over(_half_width(fitted.slope, CURVES[fitted.curve], middle), standard_level)


@dataclass(frozen=True, slots=True, kw_only=True)
class LevelOfFactor:
    """The threshold in one group, session or condition."""

    name: str
    n: int
    threshold_level: Estimate


@dataclass(frozen=True, slots=True, kw_only=True)
class Contrast:
    """Comparison of two groups, sessions or conditions.

    Parameters
    ----------
    first, second : str
    change : Estimate
        Ratio of the second threshold to the first. For a curve on a linear axis, difference between
        the thresholds, second minus first.
    p, p_holm : float
        p-values of the test against no change, uncorrected and Holm-corrected across the factor's
        pairs.
    """

    first: str
    second: str
    change: Estimate
    p: float
    p_holm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Factor:
    """Thresholds by group, by session or by the levels of a study factor.

    ``contrasts`` is empty for combinations of factors.
    """

    name: str
    levels: tuple[LevelOfFactor, ...]
    contrasts: tuple[Contrast, ...]

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, levels=Unchanged("levels"))


@dataclass(frozen=True, slots=True, kw_only=True)
class PopulationThreshold:
    """A population threshold, from a hierarchical model of all participants' answers.

    Parameters
    ----------
    threshold_level : Estimate
        Threshold of the typical participant: the centre of the normal distribution of thresholds on
        the axis of the curve.
    sd : float
        Standard deviation of thresholds between participants, in decades for a logarithmic curve,
        otherwise in µm peak to peak.
    slope : Estimate or NotComputed
        Slope of the typical participant's curve.
    sd_log_slope : float or NotComputed
        Standard deviation of the natural logarithm of the slope between participants. With several
        sessions or conditions, all participants have the same slope.
    half_width_level : Estimate or NotComputed
        Half the distance between the 25 % and 75 % points, for comparisons and for curves on a
        linear axis.
    lapse : float
        Common lapse rate of all participants.
    n, answers : int
        Counts of participants and answers.
    participants : Mapping of str to float
        Threshold of each participant in µm peak to peak, shrunk towards the population.
    factors : tuple of Factor
        Thresholds by group, by session, by each study factor and by all factors combined. Variables
        with a single level, or with fewer than `FEWEST` participants at a level, are left out.
    better_curve : str
        For comparisons, the curve of the same shape on the other axis (linear or logarithmic), if
        that curve fits clearly better. Otherwise empty.
    """

    threshold_level: Estimate
    sd: float
    slope: Estimate | NotComputed
    sd_log_slope: float | NotComputed
    half_width_level: Estimate | NotComputed
    lapse: float
    n: int
    answers: int
    participants: Mapping[str, float]
    factors: tuple[Factor, ...] = ()
    better_curve: str = ""


def population_threshold(
    rows: pd.DataFrame,
    choices: AnalysisChoices,
    *,
    method: str,
    curve: str,
    group_of: Mapping[str, str] | None = None,
) -> PopulationThreshold | NotComputed:
    """Fit a hierarchical model to all participants' answers in one task.

    Parameters
    ----------
    rows : DataFrame
        Trials of the task from `slipscale.analysis.tasks.thresholds.reading.read_choices`.
    method, curve : str
        Keys of `METHODS` and of `CURVES`.
    group_of : Mapping, optional
        Group of each participant.
    """
    model = model_of(method, curve, choices.threshold_share, choices.largest_lapse)
    main = rows[~rows["catch"]]
    main = main.assign(
        who=main[PARTICIPANT].astype(str), session=main["session"].astype(object).fillna("")
    )
    people = sorted(main["who"].unique())
    if len(people) < FEWEST:
        return NotComputed(few("participants", len(people)))
    if (presented := main["track_level"].nunique()) < FEWEST_LEVELS:
        return NotComputed(few("levels", presented, FEWEST_LEVELS))
    if len(main["correct"].unique()) < 2:  # noqa: PLR2004 - right and wrong
        return NotComputed("all answers are the same, so no curve can be fitted")
    right = _right(rows[rows["catch"]], method)
    counted = _counted(main, model)
    fit = HierarchicalFit(model, _trials(counted, np.ones((len(counted), 1)), right))
    df, confidence = len(people) - 1, choices.confidence
    found, three = fit.intervals(0, fit.slope, df=df, confidence=confidence)
    if found.value is None:
        return NotComputed("answers do not increase with the levels presented")
    slope: Estimate | NotComputed = NotComputed("the answers jump between two levels")
    compared = model.guess == "equal to lapse"
    half: Estimate | NotComputed = NotComputed("a curve of the level's logarithm has no half-width")
    if not fit.jumps:
        ends = np.exp([fit.best.theta[fit.slope], three.low, three.high]) / fit.scale
        slope = estimate(ends, confidence)
    levels = model.curve.level
    if compared or not model.curve.logarithmic:
        middle = float(levels(fit.coordinates(np.array(found.value))))
        half = _half_width(slope, model.curve, middle) if isinstance(slope, Estimate) else slope
    own = fit.coordinates(np.array([found.value])) + fit.deviations()
    return PopulationThreshold(
        threshold_level=estimate(levels(fit.coordinates(np.array(found))), confidence),
        sd=fit.sd / float(np.log(10)) if model.curve.logarithmic else fit.sd,
        slope=slope,
        sd_log_slope=(
            float(fit.best.theta[fit.unlike])
            if fit.slopes_differ
            else NotComputed("one slope is fitted to all sessions and conditions")
        ),
        half_width_level=half,
        lapse=float(fit.best.theta[fit.lapse]),
        n=len(people),
        answers=len(main),
        participants=dict(zip(people, levels(own).tolist(), strict=True)),
        factors=tuple(_factors(model, counted, right, confidence, group_of or {})),
        better_curve=_better_curve(fit, curve, counted, right) if compared else "",
    )


def population_weber(
    found: PopulationThreshold, method: str, standard_level: float
) -> Estimate | NotComputed:
    """Return the Weber fraction of the population."""
    compared = METHODS[method].guess == "equal to lapse"
    part = found.half_width_level if compared else found.threshold_level
    return over(part, standard_level) if isinstance(part, Estimate) else part


def over(found: Estimate, standard: float) -> Estimate:
    """Divide an estimate and its interval by a standard in the same unit."""
    ends = np.array([found.value, *found.interval])
    return estimate(ends / standard, found.interval.confidence)


def _half_width(slope: Estimate, curve: Curve, middle: float) -> Estimate:
    """Return half the distance between the 25 % and 75 % points on a curve, in units of the level.

    For a curve on a logarithmic axis, ``middle`` is the level at the centre of the two points.
    """
    low, high = curve.inverse(np.array([0.25, 0.75]))
    shallow, steep = slope.interval
    with np.errstate(divide="ignore"):
        values = float(high - low) / 2 / np.array([slope.value, steep, shallow])
    values = middle * np.sinh(values) if curve.logarithmic else values
    return estimate(values, slope.interval.confidence)


def _better_curve(
    fit: HierarchicalFit, curve: str, counted: pd.DataFrame, right: tuple[int, int]
) -> str:
    """Return the curve on the other axis if that curve fits clearly better, otherwise ""."""
    other, levels = OTHER_AXIS[curve], counted["track_level"].to_numpy(float)
    if levels.min() <= 0:
        return ""
    model = replace(fit.model, curve=CURVES[other])
    u = likelihood.coordinates(model.curve, levels)
    design = np.ones((len(counted), 1))
    rival = HierarchicalFit(model, _trials(counted.assign(u=u), design, right))
    gain = rival.best.log_likelihood - fit.best.log_likelihood
    return other if gain > CLEARLY else ""


def _right(catches: pd.DataFrame, method: str) -> tuple[int, int]:
    """Count correct and wrong answers to catch trials, in which wrong answers are lapses."""
    correct = catches["correct"].astype(bool)
    if METHODS[method].guess == "equal to lapse":
        more = catches["track_level"] - catches["standard_level"]
        correct, catches = correct[more != 0] == (more > 0)[more != 0], catches[more != 0]
    return int(correct.sum()), len(catches) - int(correct.sum())


def _counted(main: pd.DataFrame, model: Model) -> pd.DataFrame:
    """Return one row per participant, session, condition and level."""
    keys = ["who", "session", *factor_columns(main), "track_level"]
    counted = main.groupby(keys)["correct"].agg(["sum", "size"]).reset_index()
    u = likelihood.coordinates(model.curve, counted["track_level"].to_numpy(float))
    return counted.assign(u=u)


def _combined(rows: pd.DataFrame, names: list[str]) -> pd.Series[str]:
    """Join the labels of several columns into one label per row."""
    return rows[names].astype(str).agg(COMBINED.join, axis=1)


def _trials(counted: pd.DataFrame, design: Array, right: tuple[int, int]) -> Trials:
    return Trials(
        person=pd.factorize(counted["who"], sort=True)[0],
        condition=pd.factorize(_combined(counted, ["session", *factor_columns(counted)]))[0],
        design=design,
        u=counted["u"].to_numpy(float),
        yes=counted["sum"].to_numpy(float),
        n=counted["size"].to_numpy(float),
        catch_right=right[0],
        catch_wrong=right[1],
    )


def _factors(
    model: Model,
    counted: pd.DataFrame,
    right: tuple[int, int],
    confidence: float,
    group_of: Mapping[str, str],
) -> Iterator[Factor]:
    """Yield thresholds by group, session or condition with at least `FEWEST` people per level."""
    names = factor_columns(counted)
    by = {"group": counted["who"].map(group_of), "session": counted["session"]}
    by |= {name.removeprefix(FACTOR): counted[name].astype(str) for name in names}
    if len(names) > 1:
        by[COMBINED.join(name.removeprefix(FACTOR) for name in names)] = _combined(counted, names)
    for name, labels in by.items():
        labelled = labels.notna()
        people = counted["who"][labelled].groupby(labels[labelled]).nunique()
        if len(people) > 1 and people.min() >= FEWEST:
            others = [
                each for each in names if each.removeprefix(FACTOR) not in name.split(COMBINED)
            ]
            fitted = partial(
                _fitted, model, right, counted[labelled], _deviations(counted[labelled][others])
            )
            yield _factor(name, labels[labelled], counted["who"][labelled], fitted, confidence)


def _fitted(
    model: Model,
    right: tuple[int, int],
    counted: pd.DataFrame,
    adjusted: Array,
    design: Array,
    *start: Array,
) -> HierarchicalFit:
    trials = _trials(counted, np.column_stack([design, adjusted]), right)
    return HierarchicalFit(model, trials, *start)


def _deviations(factors: pd.DataFrame) -> Array:
    """Return design columns for the factor levels in deviation (sum-to-zero) coding."""
    columns = [
        (factors[name] == level).to_numpy(float) - (factors[name] == levels[0]).to_numpy(float)
        for name in factors
        for levels in [sorted(factors[name].unique())]
        for level in levels[1:]
    ]
    return np.array(columns).reshape(len(columns), len(factors)).T


def _factor(
    name: str,
    labels: pd.Series[str],
    who: pd.Series[str],
    fitted: Callable[..., HierarchicalFit],
    confidence: float,
) -> Factor:
    names = sorted(labels.unique(), key=numbers_first)
    people = who.nunique()
    df = people - (len(names) if name == "group" else 1)
    columns = np.stack([(labels == each).to_numpy(float) for each in names], axis=1)

    of_levels = fitted(columns)
    intervals = of_levels.intervals(*range(len(names)), df=df, confidence=confidence)
    levels = []
    for place, (label, found) in enumerate(zip(names, intervals, strict=True)):
        value = of_levels.best.theta[place] if found.value is None else found.value
        ends = of_levels.coordinates(np.array([value, found.low, found.high]))
        levels.append(
            LevelOfFactor(
                name=label,
                n=int(who[labels == label].nunique()),
                threshold_level=estimate(of_levels.model.curve.level(ends), confidence),
            )
        )
    pairs = [] if COMBINED in name else list(combinations(range(len(names)), 2))
    changes, ps = [], []
    for first, second in pairs:
        # The first level of the pair becomes the intercept, so the coefficient of the second level
        # is the change from the first.
        design, start = columns.copy(), of_levels.best.theta.copy()
        design[:, first] = 1.0
        start[: len(names)] -= np.where(np.arange(len(names)) == first, 0.0, start[first])
        fit = fitted(design, start)
        ((_, low, high),) = fit.intervals(second, df=df, confidence=confidence)
        change = fit.scale * np.array([fit.best.theta[second], low, high])
        change = np.exp(change) if fit.model.curve.logarithmic else change
        changes.append(estimate(change, confidence))
        ps.append(fit.p(second, df))
    contrasts = tuple(
        Contrast(first=names[one], second=names[other], change=change, p=p, p_holm=p_holm)
        for (one, other), change, p, p_holm in zip(pairs, changes, ps, holm(ps), strict=True)
    )
    return Factor(name=name, levels=tuple(levels), contrasts=contrasts)
