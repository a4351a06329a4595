"""Thresholds by forced choice: figures, and a row a participant."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import all_computed, computed, fold
from slipscale.analysis.tasks.thresholds import sentences as apa_thresholds
from slipscale.analysis.tasks.thresholds.statistics import COMPARED
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import TableColumn
from slipscale.analysis.writing.numbers import (
    DASH,
    bracketed,
    cell,
    p_value,
    significant,
    unit_number,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.statistics.psychometrics.psychometric_function import (
        PsychometricFunction,
    )
    from slipscale.analysis.tasks.thresholds.statistics import ParticipantThreshold, TaskThresholds

COLUMNS = (
    TableColumn(title="Participant", left=True),
    TableColumn(title="Trials"),
    TableColumn(title="Correct"),
    TableColumn(title="Threshold (µm)"),
    TableColumn(title="CI"),
    TableColumn(title="Weber fraction"),
    TableColumn(title="Slope"),
    TableColumn(title="Lapses"),
    TableColumn(title="Fit"),
)

FITTED = {
    False: "Weibull functions; the threshold is half-way between chance and the best",
    True: "Cumulative normal functions; the threshold is the point of subjective equality",
}
#: The table of the ways to fit.
WAYS = (
    TableColumn(title="Participant", left=True),
    TableColumn(title="Fitted by", left=True),
    TableColumn(title="Threshold (µm)"),
    TableColumn(title="CI"),
    TableColumn(title="Slope"),
    TableColumn(title="CI"),
    TableColumn(title="Lapses"),
)


def blocks(
    tasks: tuple[TaskThresholds, ...], svgs: Mapping[str, str], level: float
) -> list[Markup]:
    """Return the section: each task's curves, tracks and table."""
    return [block for task in tasks for block in _task(task, svgs, level)]


def _task(task: TaskThresholds, svgs: Mapping[str, str], level: float) -> list[Markup]:
    return [
        html.heading(apa_thresholds.title(task)),
        *html.figure_if_drawn(svgs, f"thresholds_{task.task}", _caption(task, level), _alt(task)),
        html.table(
            list(COLUMNS),
            [_row(each) for each in task.participants],
            f"{FITTED[task.method == COMPARED]}. Medians and {level:g} % intervals of a "
            "posterior in which the lapse rate is integrated. Lapses: 1 less the upper "
            "asymptote, at most 6 %. Fit: deviance of the likeliest curve against 1,000 data "
            "sets simulated from it.",
        ),
        html.details("The same answers, fitted in three ways", [_ways(task)]),
        *html.figure_if_drawn(
            svgs,
            f"tracks_{task.task}",
            "Levels trial by trial, a panel a participant, a colour a track: filled where "
            "the answer was correct, hollow where it was wrong. Dashed: the threshold.",
            f"Tracks of {len(task.participants)} participants",
        ),
    ]


def _ways(task: TaskThresholds) -> Markup:
    """Return a row a participant and way to fit."""
    rows = []
    for each in task.participants:
        for way, found in (
            ("posterior", each.function),
            ("maximum likelihood", each.maximum_likelihood),
            ("psignifit", each.psignifit),
        ):
            fitted = fold(found, _fitted, lambda reason: [DASH, reason, DASH, DASH, DASH])
            rows.append([each.participant, way, *fitted])
    return html.table(
        list(WAYS),
        rows,
        "Posterior: medians, lapse rate and all else integrated; what the report rests on. Maximum "
        "likelihood: profile likelihood intervals, too narrow after short tracks. psignifit 4: "
        "mode of a posterior that allows for overdispersion.",
    )


def _fitted(found: PsychometricFunction) -> list[str]:
    return [
        significant(found.threshold_um_pp.value),
        bracketed(found.threshold_um_pp.interval, significant),
        cell(found.slope, lambda slope: significant(slope.value)),
        cell(found.slope, lambda slope: bracketed(slope.interval, significant)),
        f"{100 * found.lapse:.1f} %",
    ]


def _caption(task: TaskThresholds, level: float) -> str:
    text = (
        f"{'Called more slippery' if task.method == COMPARED else 'Correct answers'} against the "
        "level. Pale: participants' psychometric functions; blue: "
        "everybody's answers, gathered by level. Below: each participant's threshold with its "
        f"{level:g} % interval (triangles: by maximum likelihood; squares: by psignifit)"
    )
    if computed(task.population) is None:
        return f"{text}."
    return f"{text}; red: the population's, with Student's interval."


def _alt(task: TaskThresholds) -> str:
    shown = [
        f"{each.participant} {significant(function.threshold_um_pp.value)} µm"
        for each in task.participants
        for function in all_computed([each.function])
    ]
    return f"Psychometric functions; thresholds: {', '.join(shown)}"


def _row(each: ParticipantThreshold) -> list[str]:
    start = [each.participant, str(each.trials), str(each.correct)]
    weber = cell(each.weber_fraction, lambda found: unit_number(found.value, 3))
    fit = cell(each.fit, lambda found: p_value(found.p))

    def fitted(found: PsychometricFunction) -> list[str]:
        threshold, interval, slope, _, lapse = _fitted(found)
        return [*start, threshold, interval, weber, slope, lapse, fit]

    return fold(
        each.function, fitted, lambda reason: [*start, DASH, reason, DASH, DASH, DASH, DASH]
    )
