"""Plot psychometric functions and the tracks of adaptive rules."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator, PercentFormatter

from slipscale.analysis.statistics.psychometrics.psychometric_function import (
    METHODS,
    PsychometricFunction,
)
from slipscale.analysis.tasks.thresholds.statistics import COMPARED, TaskThresholds
from slipscale.analysis.writing.axes import LINES_AT_MOST, tip
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES
from slipscale.figure_style import BLUE, GREY, INK, PALE, VERMILION, canvas, styled
from slipscale.stimuli.quantity import Quantity

#: Number of bins into which levels are grouped, because adaptive tracks have many levels.
BINS = 8
#: Number of panels per row, and size of a panel in inches.
ACROSS, PANEL = 3, (2.5, 1.7)
#: Largest number of participants with individual panels.
PANELS_AT_MOST = 24
#: Largest number of thresholds that are labelled with participants' names.
NAMED_AT_MOST = 30


@styled
def functions(found: TaskThresholds, trials: pd.DataFrame, quantity: Quantity) -> Figure:
    """Plot participants' psychometric functions, the answers, and thresholds with intervals.

    Parameters
    ----------
    found : TaskThresholds
        Results for the task.
    trials : DataFrame
        Trials of the task from `slipscale.analysis.tasks.thresholds.reading.read_choices`.
    quantity : Quantity
    """
    main = trials[~trials["catch"]]
    people = [each for each in found.participants if each.function]
    rows = 0.4 + 0.16 * min(len(people), NAMED_AT_MOST)
    figure, (top, bottom) = canvas(
        2, 1, size=(5.6, 3.2 + rows), sharex=True, height_ratios=[3.2, rows]
    )
    compared = found.method == COMPARED
    logarithmic = CURVES[found.curve].logarithmic
    levels = main["track_level"].to_numpy(float)
    levels = levels[levels > 0] if logarithmic else levels
    thresholds = [each.function.threshold_level.value for each in people if each.function]
    low, high = min([levels.min(), *thresholds]), max([levels.max(), *thresholds])
    margin = 0.05 * (high - low)
    fine = (
        np.geomspace(low / 1.3, high * 1.3, 200)
        if logarithmic
        else np.linspace(low - margin, high + margin, 200)
    )
    _answers(top, main[main["track_level"].isin(levels)], quantity, logarithmic=logarithmic)
    for each in people if len(people) <= LINES_AT_MOST else []:
        line = each.function
        if line:
            own = within_answers(line, main[main[PARTICIPANT].astype(str) == each.participant])
            (drawn,) = top.plot(fine, own.proportion(fine), color=PALE, linewidth=1.0, zorder=1)
            value = quantity.value(f"{line.threshold_level.value:.3g}")
            drawn.set_gid(tip(f"{each.participant}: threshold {value}"))
    top.plot([], color=PALE, linewidth=1.0, label="participants")
    chance = 0.5 if compared else METHODS[found.method].guess_rate
    top.axhline(chance, color=GREY, linewidth=0.8, linestyle=":", zorder=0)
    top.annotate("chance", (fine[-1], chance), fontsize=8, color=GREY, va="bottom", ha="right")
    top.set_ylim(-0.03 if compared else chance - 0.04, 1.03)
    top.yaxis.set_major_formatter(PercentFormatter(1.0))
    top.set_ylabel(f"Answered “{quantity.more}”" if compared else "Correct")
    _thresholds(bottom, found, quantity)
    if logarithmic:
        bottom.set_xscale("log")
        bottom.xaxis.set_major_locator(LogLocator(base=10, subs=(1, 2, 5)))
        bottom.xaxis.set_minor_locator(NullLocator())
        bottom.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    bottom.set_xlim(fine[0], fine[-1])
    over_levels = compared or found.standard_level is None
    bottom.set_xlabel(quantity.headed(quantity.title) if over_levels else quantity.change)
    drawn_in = [axes.get_legend_handles_labels() for axes in (top, bottom)]
    figure.legend(
        *([*first, *second] for first, second in zip(*drawn_in, strict=True)),
        loc="outside lower center",
        ncols=3,
    )
    return figure


def within_answers(line: PsychometricFunction, rows: pd.DataFrame) -> PsychometricFunction:
    """Let the asymptotes of a participant's curve include the proportions at the extreme levels.

    For a participant without errors, the estimated lapse rate is the posterior mean, which is above
    0. A curve with this lapse rate would not reach the observed 100 %.
    """
    levels, right = rows["track_level"], rows["correct"].astype(float)
    wrong_at_top = 1 - float(right[levels == levels.max()].mean())
    own = replace(line, lapse=min(line.lapse, wrong_at_top))
    if line.method != COMPARED:
        return own
    return replace(own, guess=min(line.guess, float(right[levels == levels.min()].mean())))


def _answers(axes: Axes, rows: pd.DataFrame, quantity: Quantity, *, logarithmic: bool) -> None:
    """Draw the proportion of answers per bin; dot area shows the number of answers."""
    levels = rows["track_level"].to_numpy(float)
    levels = np.log(levels) if logarithmic else levels
    distinct = np.unique(levels)
    if len(distinct) <= 2 * BINS:
        place = np.searchsorted(distinct, levels)
    else:
        edges = np.linspace(distinct[0], distinct[-1], BINS + 1)
        place = np.clip(np.searchsorted(edges, levels, side="right") - 1, 0, BINS - 1)
    correct = rows["correct"].to_numpy(float)
    for number in np.unique(place):
        here = place == number
        share, count = float(correct[here].mean()), int(here.sum())
        middle = float(levels[here].mean())
        middle = float(np.exp(middle)) if logarithmic else middle
        axes.scatter(
            [middle],
            [share],
            s=18 + 300 * count / len(rows),
            color=BLUE,
            zorder=3,
            clip_on=False,
            gid=tip(f"{quantity.value(f'{middle:.3g}')}: {share:.0%} of {count}"),
        )
    axes.plot([], "o", color=BLUE, label="all answers (area: their number)")


def _thresholds(axes: Axes, found: TaskThresholds, quantity: Quantity) -> None:
    people = [each for each in found.participants if each.function]
    for place, each in enumerate(people):
        if not each.function:
            continue
        estimate = each.function.threshold_level
        low, high = estimate.interval
        value = quantity.value(f"{estimate.value:.3g}")
        axes.plot([low, high], [place, place], color=PALE, linewidth=1.4, zorder=1)
        axes.plot(
            [estimate.value],
            [place],
            "o",
            color=INK,
            markersize=4,
            gid=tip(f"{each.participant}: {value} [{low:.3g}, {high:.3g}]"),
        )
    if found.population:
        low, high = found.population.threshold_level.interval
        axes.axvspan(low, high, color="#F6D7C7", linewidth=0, zorder=0)
        axes.axvline(
            found.population.threshold_level.value, color=VERMILION, linewidth=1.6, zorder=0
        )
        axes.plot([], color=VERMILION, linewidth=1.6, label="population")
    axes.set_ylim(len(people) - 0.4, -0.6)
    names = [each.participant for each in people] if len(people) <= NAMED_AT_MOST else []
    axes.set_yticks(range(len(names)), names, fontsize=7.5)
    axes.set_ylabel("Thresholds", fontsize=9)
    axes.grid(visible=False, axis="y")


@styled
def tracks(found: TaskThresholds, trials: pd.DataFrame, quantity: Quantity) -> Figure:
    """Plot the levels trial by trial, in one panel per participant."""
    main = trials[~trials["catch"]]
    people = [each for each in found.participants if each.trials][:PANELS_AT_MOST]
    rows = -(-len(people) // ACROSS)
    across = min(ACROSS, len(people))
    size = (PANEL[0] * across, PANEL[1] * rows + 0.6)
    figure, grid = canvas(rows, across, size=size, sharex=True, sharey=True, squeeze=False)
    panels = list(grid.flat)
    for axes, each in zip(panels, people, strict=False):
        own = main[main[PARTICIPANT].astype(str) == each.participant].sort_values("trial")
        for number, (_, track) in enumerate(own.groupby("track", dropna=False)):
            colour = (BLUE, VERMILION, GREY)[number % 3]
            x, y = track["trial"].to_numpy(float), track["track_level"].to_numpy(float)
            right = track["correct"].to_numpy(bool)
            axes.plot(x, y, color=colour, linewidth=0.8)
            axes.plot(x[right], y[right], "o", color=colour, markersize=2.6)
            axes.plot(x[~right], y[~right], "o", color=colour, markersize=3.4, mfc="white")
        if each.function:
            axes.axhline(each.function.threshold_level.value, color=INK, linewidth=0.9, ls="--")
        axes.set_title(each.participant, fontsize=8.5)
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(base=10, subs=(1, 2, 5)))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    for axes in panels[len(people) :]:
        axes.set_axis_off()
    figure.supxlabel("Trial", fontsize=9)
    figure.supylabel(quantity.headed("Level"), fontsize=9)
    return figure
