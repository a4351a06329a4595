"""Define how judgements are compared with measured friction, and how this is reported."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from slipscale.analysis.preprocessing import normalisation
from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants
from slipscale.analysis.statistics.measured_friction import (
    MeanCorrelation,
    MeasuredFriction,
    used_trials,
)
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declared.flat_table import flat
from slipscale.analysis.tasks.effects.friction.statistics import MEASURED_FRICTION
from slipscale.analysis.tasks.kind import Analysis, TaskAnalysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.axes import LINES_AT_MOST
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import grouped, number, p_value, significant
from slipscale.experiments.dataset.measured import COEFFICIENT
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.figure_style import BLUE, GREY, INK, PALE, canvas, styled


def measured_friction(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section on measured friction, which is empty if friction was not measured."""
    section = ReportSection("Ratings against measured friction")
    found = analysis.friction
    if found is None:
        return section
    section.blocks.append(html.paragraph(sentence(found, _spread(analysis, found)), "sentence"))
    if "rating_friction" in svgs:
        section.blocks.append(
            html.figure(
                svgs["rating_friction"],
                "Estimates against the coefficient of friction measured in the same "
                "trial. Dots: trials; thin lines: participants' means for each amplitude; "
                "thick line: means across participants (geometric means for estimates).",
                "Chart of estimates of slipperiness against the measured coefficient of friction, "
                "with a line for each participant and their mean",
            )
        )
    level = f"{analysis.dataset.choices.confidence:.0%} interval"
    section.blocks.append(
        html.table(
            [
                TableColumn(title="participant", left=True, whole=True),
                *html.columns("trials", "slope", level, "correlation", level),
            ],
            [
                [
                    line.participant_id,
                    grouped(line.trials, 0),
                    number(line.slope),
                    _interval(line.slope_interval),
                    number(line.correlation),
                    _interval(line.correlation_interval),
                ]
                for line in found.participants
            ],
            "Individual regression lines: logarithm of the estimate against the coefficient of "
            "friction. Intervals assume independent trials within each participant.",
        )
    )
    if found.left_out:
        names = ", ".join(found.left_out)
        section.blocks.append(
            html.paragraph(
                "Participants without a regression line, because they have too few trials or "
                f"no spread: {names}.",
                "note",
            )
        )
    return section


def _spread(analysis: Analysis, found: MeasuredFriction) -> float:
    """Return the range of coefficients of friction, the median of participants with a line."""
    if analysis.prepared is None:
        return math.nan
    trials = used_trials(analysis.prepared)
    by_person = trials.groupby(trials[PARTICIPANT].astype(str))[COEFFICIENT]
    lines = [line.participant_id for line in found.participants]
    return float((by_person.max() - by_person.min())[lines].median())


def sentence(found: MeasuredFriction, spread: float) -> str:
    """Return a sentence on the mean slope and the mean correlation.

    Parameters
    ----------
    found : MeasuredFriction
    spread : float
        Range of a typical participant's coefficients of friction. The effect on the estimate is
        given for a round reduction within this range.
    """
    if isinstance(found.slope, NotComputed):
        return f"Ratings were not compared with measured friction: {found.slope.reason}."
    if not found.correlation:
        return f"{_slope(found.slope, spread)}."
    return f"{_slope(found.slope, spread)}; {_correlation(found.correlation)}."


def _slope(found: MeanOverParticipants, spread: float) -> str:
    low, high = found.interval
    reduced = 10.0 ** math.floor(math.log10(spread))
    less = [math.exp(-reduced * bound) for bound in (found.mean, high, low)]
    return (
        "The slope of the logarithm of the estimate against the measured coefficient of friction "
        f"was {number(found.mean)} (mean of {found.df + 1} participants' slopes, "
        f"{found.interval.confidence:.0%} CI {_interval(found.interval)}, t({found.df}) = "
        f"{number(found.t)}, {p_value(found.p)}): reducing friction by {reduced:g}, which is "
        f"within the measured range (median {significant(spread)}), corresponds to a factor "
        f"of {number(less[0])} [{number(less[1])}, {number(less[2])}]"
    )


def _correlation(found: MeanCorrelation) -> str:
    return (
        f"the mean correlation within participants was {number(found.correlation)} "
        f"{_interval(found.interval)}"
    )


def _interval(bounds: ConfidenceInterval) -> str:
    low, high = bounds
    return f"[{number(low)}, {number(high)}]"


@styled
def rating_friction(prepared: Prepared, *, unit: str) -> Figure:
    """Plot estimates against measured coefficients of friction, by participant.

    Parameters
    ----------
    prepared : Prepared
    unit : str
        Unit of the estimates.
    """
    figure, axes = canvas(size=(4.8, 3.8))
    trials = used_trials(prepared)
    axes.scatter(
        trials[COEFFICIENT], np.exp(trials["log"]), s=9, color=PALE, linewidths=0, zorder=1
    )
    by_surface = trials.groupby([PARTICIPANT, "level"], observed=True)
    means = by_surface[[COEFFICIENT, "log"]].mean()
    people = means.groupby(level=0, observed=True)
    for _, own in people if len(people) <= LINES_AT_MOST else ():
        order = own.sort_values(COEFFICIENT)
        axes.plot(
            order[COEFFICIENT], np.exp(order["log"]), color=GREY, linewidth=0.8, alpha=0.7, zorder=2
        )
    surfaces = means.groupby(level=1).mean().sort_values(COEFFICIENT)
    axes.plot(
        surfaces[COEFFICIENT],
        np.exp(surfaces["log"]),
        color=BLUE,
        marker="o",
        markersize=6,
        markeredgecolor=INK,
        linewidth=2,
        zorder=3,
    )
    for amplitude, place in surfaces.iterrows():
        axes.annotate(
            f"{amplitude:g} µm",
            (place[COEFFICIENT], np.exp(place["log"])),
            xytext=(6, 6),
            textcoords="offset points",
            fontsize=8,
            color=INK,
            zorder=4,
        )
    axes.set_yscale("log")
    axes.set_xlabel("measured coefficient of friction")
    axes.set_ylabel(f"estimate of slipperiness\n({unit})")
    return figure


class _Friction(TaskAnalysis):
    name = "friction"
    statistics = (MEASURED_FRICTION,)

    def sections(self, analysis: Analysis, svgs: Mapping[str, str]) -> list[ReportSection]:
        return [measured_friction(analysis, svgs)]

    def figures(self, analysis: Analysis) -> Mapping[str, Figure]:
        prepared, friction = analysis.prepared, analysis.friction
        if prepared is None or friction is None or not friction.trials:
            return {}
        unit = normalisation.RULES[analysis.rule].unit.format(q=analysis.dataset.quantity)
        return {"rating_friction": rating_friction(prepared, unit=unit)}

    def tables(self, analysis: Analysis) -> Mapping[str, pd.DataFrame]:
        friction = analysis.friction
        if analysis.prepared is None or friction is None or not friction.participants:
            return {}
        return {"friction": flat(friction.participants)}


ANALYSIS = _Friction()
