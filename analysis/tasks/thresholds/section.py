"""Thresholds by forced choice: figures, and a row a participant."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declaring import section_of
from slipscale.analysis.tasks.thresholds import sentences as apa_thresholds
from slipscale.analysis.tasks.thresholds.statistics import COMPARED, THRESHOLDS
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import DASH, bracketed, p_value, significant, unit_number

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.kind import Analysis
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


def thresholds(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section: each task's curves, tracks and table."""
    section = section_of("Thresholds", analysis)
    found = analysis.inference[THRESHOLDS]
    if isinstance(found, NotComputed):
        return section
    level = 100 * analysis.dataset.choices.confidence
    for task in found:
        section.blocks.append(html.heading(apa_thresholds.title(task)))
        if (svg := svgs.get(f"thresholds_{task.task}")) is not None:
            section.blocks.append(html.figure(svg, _caption(task, level), _alt(task)))
        section.blocks.append(
            html.table(
                list(COLUMNS),
                [_row(each) for each in task.participants],
                f"{FITTED[task.method == COMPARED]}. Medians and {level:g} % intervals of a "
                "posterior in which the lapse rate is integrated. Lapses: 1 less the upper "
                "asymptote, at most 6 %. Fit: deviance of the likeliest curve against 1,000 data "
                "sets simulated from it.",
            )
        )
        section.blocks.append(html.details("The same answers, fitted in three ways", [_ways(task)]))
        if (svg := svgs.get(f"tracks_{task.task}")) is not None:
            section.blocks.append(
                html.figure(
                    svg,
                    "Levels trial by trial, a panel a participant, a colour a track: filled where "
                    "the answer was correct, hollow where it was wrong. Dashed: the threshold.",
                    f"Tracks of {len(task.participants)} participants",
                )
            )
    return section


def _ways(task: TaskThresholds) -> Markup:
    """Return a row a participant and way to fit."""
    rows = []
    for each in task.participants:
        for way, found in (
            ("posterior", each.function),
            ("maximum likelihood", each.maximum_likelihood),
            ("psignifit", each.psignifit),
        ):
            if isinstance(found, NotComputed):
                rows.append([each.participant, way, DASH, found.reason, DASH, DASH, DASH])
                continue
            slope = found.slope
            rows.append(
                [
                    each.participant,
                    way,
                    significant(found.threshold_um_pp.value),
                    bracketed(found.threshold_um_pp.interval, significant),
                    DASH if isinstance(slope, NotComputed) else significant(slope.value),
                    DASH
                    if isinstance(slope, NotComputed)
                    else bracketed(slope.interval, significant),
                    f"{100 * found.lapse:.1f} %",
                ]
            )
    return html.table(
        list(WAYS),
        rows,
        "Posterior: medians, lapse rate and all else integrated; what the report rests on. Maximum "
        "likelihood: profile likelihood intervals, too narrow after short tracks. psignifit 4: "
        "mode of a posterior that allows for overdispersion.",
    )


def _caption(task: TaskThresholds, level: float) -> str:
    text = (
        f"{'Called more slippery' if task.method == COMPARED else 'Correct answers'} against the "
        "level. Pale: participants' psychometric functions; blue: "
        "everybody's answers, gathered by level. Below: each participant's threshold with its "
        f"{level:g} % interval (triangles: by maximum likelihood; squares: by psignifit)"
    )
    if isinstance(task.population, NotComputed):
        return f"{text}."
    return f"{text}; red: the population's, with Student's interval."


def _alt(task: TaskThresholds) -> str:
    shown = [
        f"{each.participant} {significant(each.function.threshold_um_pp.value)} µm"
        for each in task.participants
        if not isinstance(each.function, NotComputed)
    ]
    return f"Psychometric functions; thresholds: {', '.join(shown)}"


def _row(each: ParticipantThreshold) -> list[str]:
    start = [each.participant, str(each.trials), str(each.correct)]
    function = each.function
    if isinstance(function, NotComputed):
        return [*start, DASH, function.reason, DASH, DASH, DASH, DASH]
    threshold = function.threshold_um_pp
    return [
        *start,
        significant(threshold.value),
        bracketed(threshold.interval, significant),
        DASH
        if isinstance(each.weber_fraction, NotComputed)
        else unit_number(each.weber_fraction.value, 3),
        DASH if isinstance(function.slope, NotComputed) else significant(function.slope.value),
        f"{100 * function.lapse:.1f} %",
        DASH if isinstance(each.fit, NotComputed) else p_value(each.fit.p),
    ]
