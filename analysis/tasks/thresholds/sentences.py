"""Write sentences on thresholds."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from slipscale.analysis.preprocessing.sufficiency import FEWEST
from slipscale.analysis.statistics.not_computed import NotComputed, fold, missing
from slipscale.analysis.statistics.psychometrics.psychometric_function import METHODS
from slipscale.analysis.tasks.thresholds.cautions import CAUTIONS
from slipscale.analysis.tasks.thresholds.friction_axis import FrictionThreshold
from slipscale.analysis.tasks.thresholds.population_threshold import Factor, PopulationThreshold
from slipscale.analysis.tasks.thresholds.reversals import ConditionReversals, Reversals
from slipscale.analysis.tasks.thresholds.slopes_by_condition import SlopesByCondition
from slipscale.analysis.tasks.thresholds.statistics import COMPARED, TaskThresholds
from slipscale.analysis.writing.factor_words import factor_level, factor_name
from slipscale.analysis.writing.numbers import (
    bracketed,
    joined,
    level_of,
    p_value,
    significant,
    unit_number,
)
from slipscale.analysis.writing.task_names import task_name
from slipscale.analysis.writing.verdicts import DIFFERED, verdict
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES
from slipscale.stimuli.quantity import Quantity, capitalised

_HALF_WAY = "for a typical participant (n = {n}), half-way between chance and best performance"
#: Text before and after the threshold in a sentence, keyed by method.
MEANT = {
    "two_interval": ("", f"{_HALF_WAY} (two-interval forced choice)"),
    "three_interval": ("", f"{_HALF_WAY} (three-interval forced choice)"),
    # Half-way is 2/3 correct: d' is 2.32 in the triangular method (Ennis 1993, Journal of Sensory
    # Studies 8, 353-370), and 0.95 half-way in two-interval forced choice.
    "oddity": (
        "",
        (
            f"{_HALF_WAY} (oddity with three intervals, for which this corresponds to a d′ of "
            "2.32, instead of 0.95 in two-interval and 1.12 in three-interval forced choice)"
        ),
    ),
    COMPARED: (
        "point of subjective equality ",
        "for a typical participant (n = {n}); at this level, half of the answers are “{q.more}”",
    ),
}

#: How the points of few participants are averaged.
OWN_CURVES = "the mean of the participants' own curves"
#: Note on poor fits if a study has several sessions or conditions.
POOLED = (
    "; each curve pools all sessions and conditions, so differences between them also count as "
    "misfit"
)


def title(found: TaskThresholds, quantity: Quantity) -> str:
    """Return the name under which the report lists a task.

    >>> from types import SimpleNamespace
    >>> from slipscale.stimuli.quantity import PLATE_AMPLITUDE
    >>> task = SimpleNamespace(task="oddity", standard_level=1.2, method="oddity")
    >>> title(task, PLATE_AMPLITUDE)
    'Difference threshold by oddity at 1.2 µm'
    """
    if found.method == COMPARED:
        around = "" if found.standard_level is None else quantity.value(found.standard_level)
        return task_name(f"Constant stimuli{around and ' around '}{around}", found.task)
    if found.standard_level is None:
        return task_name("Detection threshold", found.task)
    by = "" if METHODS[found.method].by_magnitude else " by oddity"
    at = quantity.value(found.standard_level)
    return task_name(f"Difference threshold{by} at {at}", found.task)


def answers(found: TaskThresholds, confidence: float, quantity: Quantity) -> list[str]:
    """Return sentences on thresholds by condition, the population threshold and Weber fraction."""
    factors = _tested(found.population) if found.population else []
    return [
        *(_by(factor, found, confidence, quantity) for factor in factors),
        *(_slopes_by(factor, found, confidence, quantity) for factor in found.slopes),
        _pooled(found, confidence, quantity),
    ]


def _tested(joint: PopulationThreshold) -> list[Factor]:
    return [factor for factor in joint.factors if factor.contrasts]


def _by(factor: Factor, found: TaskThresholds, confidence: float, quantity: Quantity) -> str:
    values = "; ".join(
        f"{quantity.value(significant(each.threshold_level.value))}, {level_of(confidence)} CI "
        f"{bracketed(each.threshold_level.interval, significant)} "
        f"({factor_level(factor.name, each.name)})"
        for each in factor.levels
    )
    told: dict[str, list[str]] = {DIFFERED.past: []}
    people = found.population.n if found.population else 0
    for each in factor.contrasts:
        one, other = (factor_level(factor.name, name) for name in (each.first, each.second))
        verb = verdict(DIFFERED, each.p_holm, confidence, people - 1)
        told.setdefault(verb, []).append(f"between {one} and {other} ({p_value(each.p_holm)})")
    tests = ", and ".join(f"{verb} {joined(pairs)}" for verb, pairs in told.items() if pairs)
    what = f"{title(found, quantity)} by {factor_name(factor.name)}: {MEANT[found.method][0]}"
    return f"{what}{values}. Thresholds {tests}, after Holm's correction."


def _slopes_by(
    factor: SlopesByCondition, found: TaskThresholds, confidence: float, quantity: Quantity
) -> str:
    def listed(levels: Mapping[str, float]) -> str:
        return "; ".join(
            f"{quantity.value(significant(level))} ({factor_level(factor.name, name)})"
            for name, level in levels.items()
            if np.isfinite(level)
        )

    # With enough people, the population's points are in another sentence.
    points = "" if found.population else listed(factor.points_level)
    points = points and f"point of subjective equality {points}, {OWN_CURVES}; "
    tests = []
    for each in factor.contrasts:
        one, other = (factor_level(factor.name, name) for name in (each.first, each.second))
        if isinstance(each.log_ratio, NotComputed) or each.p_holm is None:
            continue
        verb = verdict(DIFFERED, each.p_holm, confidence, each.log_ratio.df)
        ratio = bracketed(each.log_ratio.interval, lambda end: significant(float(np.exp(end))))
        tests.append(
            f"{verb} between {one} and {other} "
            f"(ratio {significant(float(np.exp(each.log_ratio.mean)))}, "
            f"{level_of(confidence)} CI {ratio}, "
            f"t({each.log_ratio.df}) = {unit_number(each.log_ratio.t, 2)}, {p_value(each.p_holm)})"
        )
    compared = f" Slopes {joined(tests)}, after Holm's correction." if tests else ""
    what = f"{title(found, quantity)} by {factor_name(factor.name)}"
    widths = listed(factor.half_widths_level) or "not determined"
    return f"{what}: {points}just noticeable difference {widths}.{compared}"


def averaged(found: TaskThresholds) -> str:
    """Return the conditions over which the population threshold is averaged, in words."""
    if not found.population:
        return ""
    names = [factor_name(factor.name) for factor in _tested(found.population)]
    if not names and isinstance(found.population.sd_log_slope, NotComputed):
        names = ["sessions and conditions"]
    return f", averaged over {joined(names)}" if names else ""


def _pooled(found: TaskThresholds, confidence: float, quantity: Quantity) -> str:
    what = f"{title(found, quantity)}{averaged(found)}"
    if isinstance(found.population, NotComputed):
        own = "" if len(found.participants) >= FEWEST else _own(found, confidence, quantity)
        return f"{what}: {own}no population threshold was computed ({found.population.reason})."
    threshold = found.population.threshold_level
    curve = CURVES[found.curve]
    axis = "logarithmic" if curve.logarithmic else "linear"
    text = (
        f"{what}: {MEANT[found.method][0]}"
        f"{quantity.with_convention(significant(threshold.value))}, {level_of(confidence)} CI "
        f"{bracketed(threshold.interval, significant)}, "
        f"{MEANT[found.method][1].format(n=found.population.n, q=quantity)}"
    )
    half = found.population.half_width_level
    if found.standard_level is None and found.method == COMPARED and half:
        text += (
            f"; just noticeable difference {quantity.value(significant(half.value))}, CI "
            f"{bracketed(half.interval, significant)}"
        )
    if found.weber_fraction:
        weber = found.weber_fraction
        text += (
            f"; Weber fraction {unit_number(weber.value, 3)}, CI "
            f"{bracketed(weber.interval, lambda value: unit_number(value, 3))}"
        )
    return f"{text} ({curve.title}, {axis} axis)."


def _own(found: TaskThresholds, confidence: float, quantity: Quantity) -> str:
    """Return the threshold and slope of each participant, or why there is none."""
    text = ""
    for person in found.participants:
        function = person.function
        if isinstance(function, NotComputed):
            text += f"no function was fitted for {person.participant} ({function.reason}); "
            continue
        ends = bracketed(function.threshold_level.interval, significant)
        what = "point of subjective equality" if found.method == COMPARED else "threshold"
        text += (
            f"{what} of {person.participant} "
            f"{quantity.with_convention(significant(function.threshold_level.value))}, "
            f"{level_of(confidence)} CI {ends}; slope {significant(function.slope_value)} "
            f"({CURVES[found.curve].title}, {person.trials} answers); "
        )
    return text


def doubts(task: TaskThresholds, _confidence: float, quantity: Quantity) -> list[str]:
    """Return a caveat if another curve, such as one on a linear axis, fits clearly better."""
    if not task.population or not task.population.better_curve:
        return []
    better = task.population.better_curve
    text = (
        f"{title(task, quantity)}: the {CURVES[better].title} describes the "
        f"answers clearly better than the {CURVES[task.curve].title}, so threshold and slope may "
        f'be biased; set threshold_curve = "{better}" in [analysis].'
    )
    return [text]


def _slopes(joint: PopulationThreshold) -> str:
    if isinstance(joint.sd_log_slope, NotComputed):
        return joint.sd_log_slope.reason
    times = significant(float(np.exp(joint.sd_log_slope)))
    if times == significant(1.0):
        return "participants' slopes are estimated to be equal"
    return f"one SD of participants' slopes is a factor of {times}"


def _no_spread(joint: PopulationThreshold, curve: str) -> str:
    """Return a clause if the estimated SD of participants' thresholds is 0, its boundary."""
    decades = CURVES[curve].logarithmic
    times = 10**joint.sd if decades else 1 + joint.sd / abs(joint.threshold_level.value)
    if significant(float(times)) != significant(1.0):
        return ""
    return (
        "; the SD of participants' thresholds is estimated as 0, so differences between their "
        "thresholds were not distinguishable from 0"
    )


def _change(change: float, task: TaskThresholds, quantity: Quantity) -> str:
    if CURVES[task.curve].logarithmic:
        return f"{significant(change)} times as high"
    return f"{quantity.value(significant(change))} higher"


def _reversals(found: Reversals, confidence: float, quantity: Quantity) -> str:
    def mean(each: ConditionReversals) -> str:
        n = sum(np.isfinite(person.mean_level) for person in each.people)
        value = fold(
            each.mean_level,
            lambda found: (
                f"{quantity.value(significant(found.value))}, {level_of(confidence)} CI "
                f"{bracketed(found.interval, significant)}, n = {n}"
            ),
            lambda reason: f"not computed ({reason})",
        )
        return f"{value} ({each.condition})" if each.condition else value

    left_out = sum(each.left_out for each in found.conditions)
    tracks = sum(each.tracks for each in found.conditions)
    short = (
        f" {left_out} of {tracks} tracks have fewer than {found.last} reversals and are left out."
    )
    means = "; ".join(map(mean, found.conditions))
    return (
        f"The mean of the last {found.last} reversals per track, which estimates the level with "
        f"about {100 * found.proportion:.0f} % correct answers (Levitt, 1971), was {means}."
        f"{short if left_out else ''}"
    )


def _friction(found: FrictionThreshold, method: str, confidence: float, quantity: Quantity) -> str:
    by = "means per participant and level" if found.averaged else "single trials"
    more = f"half of the answers are “{quantity.more}”"
    text = (
        f"In terms of measured friction ({by}), "
        f"{more if method == COMPARED else 'the threshold is'} at a coefficient "
        f"{significant(found.change.value)} {'lower' if found.lower else 'higher'} than the mean "
        f"of the other surfaces ({significant(found.standard)}), {level_of(confidence)} CI "
        f"{bracketed(found.change.interval, significant)}"
    )
    if method == COMPARED:
        text += fold(
            found.just_noticeable,
            lambda just: (
                f"; just noticeable difference {significant(just.value)}, CI "
                f"{bracketed(just.interval, significant)}"
            ),
            lambda reason: f"; the just noticeable difference was not computed ({reason})",
        )
    if found.weber_fraction:
        text += f"; Weber fraction {unit_number(found.weber_fraction.value, 3)}"
    if np.isfinite(found.scatter):
        text += (
            f"; the SD of single-trial changes around their mean is {significant(found.scatter)}"
        )
    if not found.averaged:
        text += "; noise in individual measurements makes just noticeable differences too large"
    if found.left_out:
        text += f"; {found.left_out} trials without a measurement were left out"
    return f"{text}."


def remarks(task: TaskThresholds, confidence: float, quantity: Quantity) -> list[str]:
    """Return sentences on goodness of fit, catch trials, conditions and cautions."""
    parts = []
    fits = [each.fit for each in task.participants if each.fit]
    if fits:
        bad = sum(fit.p < 1 - confidence for fit in fits)
        pooled = bad and task.population and isinstance(task.population.sd_log_slope, NotComputed)
        parts.append(
            f"{bad} of {len(fits)} individual curves fit poorly (p < "
            f"{unit_number(1 - confidence)}){POOLED if pooled else ''}."
        )
    catches = sum(each.catch_trials for each in task.participants)
    if catches:
        right = sum(each.catch_correct for each in task.participants)
        parts.append(f"Catch trials: {right} of {catches} correct.")
    parts += [
        f"{each.participant} has no threshold: {lacking.reason}."
        for each in task.participants
        for lacking in missing([each.function])
    ]
    parts += [
        f"{each.participant}'s threshold, "
        f"{quantity.value(significant(each.function.threshold_level.value))}, is outside the "
        f"presented levels ({each.presented_levels[0]:g} to "
        f"{quantity.value(f'{each.presented_levels[1]:g}')}): it is extrapolated, and the answers "
        "do not show that there is a threshold."
        for each in task.participants
        if each.function and each.extrapolated
    ]
    if task.reversals:
        parts.append(_reversals(task.reversals, confidence, quantity))
    if task.friction:
        parts.append(_friction(task.friction, task.method, confidence, quantity))
    if task.population:
        joint = task.population
        parts.append(
            f"In the hierarchical model of {joint.answers} answers, the lapse rate is "
            f"{100 * joint.lapse:.1f} %; {_slopes(joint)}{_no_spread(joint, task.curve)}."
        )
        parts += [
            f"{capitalised(factor_name(factor.name))} {factor_level(factor.name, each.second)} "
            f"compared with {factor_level(factor.name, each.first)}: the threshold is "
            f"{_change(each.change.value, task, quantity)}, CI "
            f"{bracketed(each.change.interval, significant)}, {p_value(each.p_holm)} after Holm's "
            "correction."
            for factor in joint.factors
            for each in factor.contrasts
        ]
        parts += [str(each) for each in CAUTIONS if each.applies(task)]
    return parts
