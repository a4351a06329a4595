"""Write the report section on thresholds."""

from __future__ import annotations

from collections.abc import Mapping
from math import exp, isfinite
from statistics import median

from markupsafe import Markup

from slipscale.analysis.statistics.not_computed import NotComputed, all_computed, computed, fold
from slipscale.analysis.statistics.psychometrics.psychometric_function import (
    Estimate,
    PsychometricFunction,
)
from slipscale.analysis.tasks.thresholds.sentences import averaged
from slipscale.analysis.tasks.thresholds.statistics import (
    COMPARED,
    ParticipantThreshold,
    TaskThresholds,
)
from slipscale.analysis.writing import html
from slipscale.analysis.writing.factor_words import factor_level, factor_name
from slipscale.analysis.writing.numbers import (
    DASH,
    bracketed,
    cell,
    p_value,
    significant,
    unit_number,
)
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES
from slipscale.stimuli.quantity import Quantity

#: Headings of the columns that describe a fit.
FIT = ("CI", "In the population fit", "Weber fraction", "Slope", "Lapses", "Fit")

FITTED = {
    False: "the threshold is half-way between chance and best performance",
    True: "the threshold is the point of subjective equality",
}
CONTRASTS = html.columns("Compared", "Change", "CI", "p", "Holm's p", left=1)


def blocks(
    task: TaskThresholds, svgs: Mapping[str, str], level: float, quantity: Quantity
) -> list[Markup]:
    """Return the figures and tables for one task."""
    caption, alt = _caption(task, level, quantity), _alt(task, quantity)
    fits = [each.fit for each in task.participants if each.fit]
    fitted = (
        f" Fit: deviance compared with {fits[0].simulations} simulated data sets." if fits else ""
    )
    titles = ("Participant", "Trials", "Correct", quantity.heading("Threshold"), *FIT)
    each_participant = html.table(
        html.columns(*titles, left=1),
        [_row(each, task) for each in task.participants],
        f"{CURVES[task.curve].title}; {FITTED[task.method == COMPARED]}. “In the population fit”: "
        "individual thresholds, shrunk towards the population threshold. Lapses: 1 minus the upper "
        f"asymptote, at most 6 %.{fitted}",
    )
    return [
        *html.figure_if_drawn(svgs, f"thresholds_{task.task}", caption, alt),
        html.details(_range(task, quantity), [each_participant]),
        *_factors(task, quantity),
        *_slopes(task, quantity),
        *html.figure_if_drawn(
            svgs,
            f"tracks_{task.task}",
            "Levels trial by trial, one colour per track. Filled markers: correct answers; hollow "
            "markers: wrong answers. Dashed line: the threshold.",
            f"Tracks of {len(task.participants)} participants",
        ),
    ]


def _range(task: TaskThresholds, quantity: Quantity) -> str:
    found = [each.function.threshold_level.value for each in task.participants if each.function]
    if not found:
        return "Individual participants"
    low, middle, high = map(significant, (min(found), median(found), max(found)))
    everyone = len(task.participants)
    left_out = (
        f" (n = {len(found)} of {everyone}; without participants whose threshold was not found, so "
        "this range and median are biased)"
        if len(found) < everyone
        else ""
    )
    return f"Individual participants: {low} to {quantity.value(high)}, median {middle}{left_out}"


def _factors(task: TaskThresholds, quantity: Quantity) -> list[Markup]:
    if isinstance(task.population, NotComputed):
        return []
    tables = []
    change = (
        "ratio"
        if CURVES[task.curve].logarithmic
        else ", ".join(filter(None, ("difference", quantity.unit)))
    )
    titles = ("Threshold by", "Level", "Participants", quantity.heading("Threshold"), "CI")
    for factor in task.population.factors:
        rows = [
            [
                factor_name(factor.name),
                factor_level(factor.name, each.name),
                str(each.n),
                *_interval_cells(each.threshold_level),
            ]
            for each in factor.levels
        ]
        tables.append(
            html.table(
                html.columns(*titles, left=2),
                rows,
                "Estimates from the model of all participants' answers.",
            )
        )
        compared = [
            [
                _pair(factor.name, each.second, each.first),
                *_interval_cells(each.change),
                p_value(each.p),
                p_value(each.p_holm),
            ]
            for each in factor.contrasts
        ]
        if compared:
            tables.append(html.table(CONTRASTS, compared, f"Change: {change} of thresholds."))
    return tables


def _slopes(task: TaskThresholds, quantity: Quantity) -> list[Markup]:
    """Return the tables of slopes in the conditions of each factor."""
    titles = ("Slope by", "Level", quantity.heading("Just noticeable difference"))
    tables = []
    for factor in task.slopes:
        rows = [
            [factor_name(factor.name), factor_level(factor.name, name), _finite(half)]
            for name, half in factor.half_widths_level.items()
        ]
        note = (
            "Geometric means of participants' curves without lapses, which few answers do not "
            "determine."
        )
        tables.append(html.table(html.columns(*titles, left=2), rows, note))
        compared = [
            [
                _pair(factor.name, each.second, each.first),
                significant(exp(each.log_ratio.mean)),
                bracketed(each.log_ratio.interval, lambda end: significant(exp(end))),
                p_value(each.log_ratio.p),
                p_value(each.p_holm),
            ]
            for each in factor.contrasts
            if not isinstance(each.log_ratio, NotComputed) and each.p_holm is not None
        ]
        if compared:
            tables.append(html.table(CONTRASTS, compared, "Change: ratio of slopes."))
    return tables


def _finite(value: float) -> str:
    return significant(value) if isfinite(value) else DASH


def _pair(factor: str, second: str, first: str) -> str:
    return " compared with ".join(factor_level(factor, name) for name in (second, first))


def _interval_cells(found: Estimate) -> list[str]:
    return [significant(found.value), bracketed(found.interval, significant)]


def _fitted(found: PsychometricFunction) -> list[str]:
    return [
        *_interval_cells(found.threshold_level),
        cell(found.slope, lambda slope: significant(slope.value)),
        f"{100 * found.lapse:.1f} %",
    ]


def _caption(task: TaskThresholds, level: float, quantity: Quantity) -> str:
    called = f"Proportion of “{quantity.more}” answers"
    text = (
        f"{called if task.method == COMPARED else 'Proportion correct'} as a function of the "
        "level. Pale: individual psychometric functions; blue: all answers pooled. Bottom: "
        f"individual thresholds with {level:g} % intervals"
    )
    if computed(task.population) is None:
        return f"{text}."
    return f"{text}; red: the population threshold{averaged(task)}."


def _alt(task: TaskThresholds, quantity: Quantity) -> str:
    shown = [
        f"{each.participant} {quantity.value(significant(function.threshold_level.value))}"
        for each in task.participants
        for function in all_computed([each.function])
    ]
    return f"Psychometric functions; thresholds: {', '.join(shown)}"


def _row(each: ParticipantThreshold, task: TaskThresholds) -> list[str]:
    start = [each.participant, str(each.trials), str(each.correct)]
    joint = fold(
        task.population, lambda found: significant(found.participants[each.participant]), _dash
    )
    weber = cell(each.weber_fraction, lambda found: unit_number(found.value, 3))
    fit = cell(each.fit, lambda found: p_value(found.p))

    def fitted(found: PsychometricFunction) -> list[str]:
        threshold, interval, slope, lapse = _fitted(found)
        return [*start, threshold, interval, joint, weber, slope, lapse, fit]

    return fold(
        each.function, fitted, lambda reason: [*start, DASH, reason, joint, DASH, DASH, DASH, DASH]
    )


def _dash(_reason: str) -> str:
    return DASH
