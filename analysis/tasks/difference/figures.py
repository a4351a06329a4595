"""Plot the answers of the descending difference task."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.difference.step_size_curve import PsychometricCurve, curve
from slipscale.analysis.tasks.difference.yes_no import (
    DescendingDifference,
    StepAnswers,
    interval_of,
    step_sizes,
)
from slipscale.analysis.writing.axes import LINES_AT_MOST, tip
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.figure_style import BLUE, GREY, INK, PALE, VERMILION, canvas, styled
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity, capitalised

#: Area of the ring that represents one participant, in square points.
RING = 34.0
#: Height of a row in the upper panel, and of the lower panel, in inches.
ROW, LOWER = 0.36, 2.9


@styled
def difference(
    found: DescendingDifference,
    steps: pd.DataFrame,
    *,
    confidence: float = 0.95,
    quantity: Quantity = PLATE_AMPLITUDE,
) -> Figure:
    """Plot the proportion of "yes" answers for each step and as a function of step size.

    Parameters
    ----------
    found : DescendingDifference
        Result of `slipscale.analysis.tasks.difference.yes_no.analyse_differences`.
    steps : DataFrame
        The analysed steps: `slipscale.analysis.reading.dataset.Dataset.differences`.
    confidence : float
        Confidence level of the intervals and of the band around the curve.
    quantity : Quantity
        Quantity of the steps.
    """
    rows = len(found.steps) + (found.catch.n > 0)
    upper = 0.9 + ROW * rows
    sizes = step_sizes(steps)
    if len(np.unique(sizes)) == 1:
        figure, axes = canvas(size=(6.8, upper))
        _each_step(axes, found, confidence, quantity)
        return figure
    figure, (top, bottom) = canvas(2, 1, (5.6, upper + LOWER), height_ratios=[upper, LOWER])
    figure.set_layout_engine("constrained", hspace=0.08)
    _each_step(top, found, confidence, quantity)
    top.set_title(f"Each {quantity.yes_no.each}")
    _against_size(bottom, found.psychometric, steps.assign(size=sizes), confidence, quantity)
    bottom.set_title(f"Against {quantity.yes_no.size}")
    if not quantity.stepped:
        above = ": above the reference" if steps["level"].any() else ""
        bottom.set_xlabel(f"{quantity.axis}{above}")
        bottom.set_ylabel(f"“{capitalised(quantity.yes)}”")
    # The legend is outside, because data can be anywhere in the axes.
    figure.legend(*bottom.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def step_label(step: StepAnswers, quantity: Quantity) -> str:
    """Return the label of a step, such as "2.3 → 1.2 µm"."""
    if quantity.stepped:
        return f"{step.from_level:g} → {quantity.value(step.to_level)}"
    stimulus = quantity.value(step.from_level)
    return f"{stimulus} against {step.to_level:g}" if step.to_level else stimulus


def _each_step(
    axes: Axes, found: DescendingDifference, confidence: float, quantity: Quantity
) -> None:
    labels = [step_label(step, quantity) for step in found.steps]
    rows: list[tuple[int, int, ConfidenceInterval, str, str]] = [
        (step.yes, step.n, step.interval, BLUE, "o") for step in found.steps
    ]
    if found.catch.interval is not None:
        labels.append("catch: no change" if quantity.stepped else "catch: at the reference")
        rows.append((found.catch.yes, found.catch.n, found.catch.interval, VERMILION, "s"))
    for place, (yes, n, (low, high), colour, marker) in enumerate(rows):
        share = yes / n
        axes.errorbar(
            share,
            place,
            xerr=[[share - low], [high - share]],
            color=colour,
            marker=marker,
            markersize=7,
            capsize=4,
            linewidth=1.8,
            clip_on=False,
            zorder=3,
        )[0].set_gid(tip(f"{labels[place]}: {share:.0%}, interval {low:.0%} to {high:.0%}"))
        axes.annotate(
            f"{yes} of {n}",
            (1.03, place),
            xycoords=("axes fraction", "data"),
            va="center",
            fontsize=8.5,
            color=GREY,
            annotation_clip=False,
        )
    axes.set_yticks(range(len(rows)), labels)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_xlim(0, 1)
    axes.xaxis.set_major_formatter(PercentFormatter(1.0))
    axes.grid(visible=True, axis="x")
    axes.grid(visible=False, axis="y")
    asked = "“Yes, I feel a difference”" if quantity.stepped else f"“{capitalised(quantity.yes)}”"
    axes.set_xlabel(f"{asked} ({100 * confidence:g} % intervals)")


def _against_size(
    axes: Axes,
    fit: PsychometricCurve | NotComputed,
    steps: pd.DataFrame,
    confidence: float,
    quantity: Quantity,
) -> None:
    level = f"{100 * confidence:g} %"
    sizes = np.unique(steps["size"])
    span = float(np.ptp(sizes))
    if fit:
        fine = np.linspace(sizes[0], sizes[-1], 200)
        middle, low, high = curve(fit, fine, confidence)
        axes.plot(fine, middle, color=BLUE, linewidth=1.8, label="logistic curve", zorder=2)
        axes.fill_between(
            fine,
            low,
            high,
            color="#CCE3F0",
            linewidth=0,
            label=f"{level} band of the curve",
            zorder=0,
        )
        if fit.half_yes and fit.half_yes_interval:
            ends = fit.half_yes_interval
            axes.errorbar(
                fit.half_yes,
                0.5,
                xerr=[[fit.half_yes - ends.low], [ends.high - fit.half_yes]],
                color=INK,
                linestyle="none",
                marker="|",
                markersize=9,
                capsize=3,
                zorder=3,
                label=f"half of the answers are “{quantity.yes}” ({level} interval)",
            )
    if 1 < steps[PARTICIPANT].nunique() <= LINES_AT_MOST:
        _participants(axes, steps)
    for size in sizes:
        answers = steps[steps["size"] == size]
        yes, n = int(answers["difference_felt"].sum()), len(answers)
        changed = size != 0
        below, above = interval_of(answers, confidence)
        axes.errorbar(
            size,
            yes / n,
            yerr=[[yes / n - below], [above - yes / n]],
            color=BLUE if changed else VERMILION,
            marker="o" if changed else "s",
            markersize=7,
            capsize=4,
            linewidth=1.8,
            clip_on=False,
            zorder=4,
            label=f"all answers ({level} interval)" if size == sizes[-1] else None,
        )
    axes.set_xticks(sizes, ["0\n(catch)" if s == 0 else f"{s:g}" for s in sizes])
    axes.set_xlim(sizes[0] - 0.06 * span, sizes[-1] + 0.06 * span)
    axes.set_ylim(-0.09, 1.11)
    axes.set_yticks(np.linspace(0, 1, 6))
    axes.yaxis.set_major_formatter(PercentFormatter(1.0))
    axes.set_xlabel(quantity.headed(f"{quantity.title} removed"))
    axes.set_ylabel("“Yes, I feel a difference”")


def _participants(axes: Axes, steps: pd.DataFrame) -> None:
    """Plot participants' proportions as rings whose area shows the number of people."""
    own = (
        steps.groupby(["size", steps[PARTICIPANT].astype(str)])["difference_felt"]
        .mean()
        .reset_index()
    )
    counted = own.groupby(["size", "difference_felt"]).size()
    rows = counted.reset_index(name="people").to_numpy(float).tolist()
    # The legend shows the ring of one person, because larger rings would cover other entries.
    axes.plot(
        [],
        linestyle="none",
        marker="o",
        markersize=RING**0.5,
        markerfacecolor="none",
        markeredgecolor=PALE,
        markeredgewidth=1.1,
        label="participants (area: their number)",
    )
    for size, share, people in rows:
        axes.scatter(
            [size],
            [share],
            s=RING * people,
            facecolors="none",
            edgecolors=PALE,
            linewidths=1.1,
            clip_on=False,
            zorder=3,
            gid=tip(f"{people:g} participants: {share:.0%}"),
        )
