"""Define the comparison of exponent and Weber fraction in the report."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.psychometric_function import Estimate
from slipscale.analysis.tasks.exponent_and_weber.statistics import (
    EKMAN,
    EXPONENT_AND_WEBER,
    PUBLISHED,
    ExponentAndWeber,
)
from slipscale.analysis.tasks.kind import Analysis, TaskAnalysis
from slipscale.analysis.tasks.thresholds.statistics import THRESHOLDS
from slipscale.analysis.writing import html
from slipscale.analysis.writing.axes import tip
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import bracketed, counted, level_of, unit_number
from slipscale.figure_style import BLUE, GREY, PALE, VERMILION, canvas, styled
from slipscale.stimuli.quantity import Quantity

#: Ends of sentences that begin with "The exponent", keyed by conclusion.
VERDICTS = {
    "agrees": "agrees with the Weber fraction",
    "does not agree": "does not agree with the Weber fraction",
    "undecided": "can be neither shown to agree with the Weber fraction nor to differ from it, "
    "because the interval is too wide",
}


def _sentences(analysis: Analysis) -> list[str]:
    found, data = analysis.inference.found(EXPONENT_AND_WEBER) or (), analysis.dataset
    return [sentence(one, data.choices.confidence, data.quantity) for one in found]


def sentence(one: ExponentAndWeber, confidence: float, quantity: Quantity) -> str:
    """Return a sentence on the measured and the expected values, with the verdict."""
    level = level_of(confidence)
    low, high = PUBLISHED
    people = counted(len(one.participants), "participant has", "participants have")
    weber = f"{unit_number(one.weber_fraction.value, 3)}, CI {_bracketed(one.weber_fraction)}"
    expected = one.expected_exponent
    text = (
        f"{people} both: the exponent is {one.exponent.value:.2f}, {level} CI "
        f"{bracketed(one.exponent.interval)}; the Weber fraction at "
        f"{quantity.value(one.standard_level)} ({one.task}) is {weber}. By Ekman's law "
        f"with {unit_number(EKMAN, 2)} (Teghtsoonian, 1971), this Weber fraction "
        f"corresponds to an exponent of {expected.value:.2f}, CI "
        f"{bracketed(expected.interval)}. Here, a just noticeable difference is "
        f"{unit_number(one.ekman_fraction.value, 3)} of the sensation, CI "
        f"{_bracketed(one.ekman_fraction)} (published values: {unit_number(low, 3)} to "
        f"{unit_number(high, 3)}). The exponent {VERDICTS[one.verdict]}."
    )
    if one.grows:
        return text
    return (
        f"{text} The exponent's interval contains 0, so the data do not show that "
        f"sensation increases with the {quantity.level}."
    )


def _bracketed(found: Estimate) -> str:
    return bracketed(found.interval, lambda value: unit_number(value, 3))


def section_of(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section with the comparison, or with the reason why it is missing.

    Without magnitude estimates or without thresholds, the section is empty.
    """
    section = ReportSection("Exponent and Weber fraction")
    found = analysis.inference[EXPONENT_AND_WEBER]
    if isinstance(found, NotComputed):
        if analysis.prepared is not None and not isinstance(
            analysis.inference[THRESHOLDS], NotComputed
        ):
            section.blocks.append(
                html.paragraph(
                    f"The exponent and the Weber fraction were not compared: {found.reason}.",
                    "note",
                )
            )
        return section
    confidence, quantity = analysis.dataset.choices.confidence, analysis.dataset.quantity
    section.gist = _sentences(analysis)
    for one in found:
        if (svg := svgs.get(f"exponent_and_weber_{one.task}")) is not None:
            section.blocks.append(
                html.figure(
                    svg,
                    "Each participant's exponent against their Weber fraction, and the means "
                    f"with {100 * confidence:g} % intervals. Line: Ekman's law with k = 0.03; "
                    "band: 0.025 to 0.035, as found for nine continua (Teghtsoonian 1971).",
                    f"Exponents and Weber fractions of {len(one.participants)} participants",
                )
            )
    section.blocks.append(
        html.paragraph(
            "Ekman's law describes a whole sensory continuum and its just noticeable differences. "
            f"This exponent describes only the {quantity.levels} rated here; exponents are smaller "
            "for wider ranges.",
            "note",
        )
    )
    return section


@styled
def exponent_and_weber(found: ExponentAndWeber) -> Figure:
    """Plot participants, means with intervals, and the curve according to Ekman's law."""
    figure, axes = canvas()
    weber = np.array([each.weber_fraction for each in found.participants])
    own = np.array([each.exponent for each in found.participants])
    # On a logarithmic axis, an interval that reaches 0 extends beyond the figure.
    ends = [end for end in (*weber, *found.weber_fraction.interval) if end > 0]
    fine = np.geomspace(min(ends) / 1.4, max(ends) * 1.4, 100)
    low, high = (np.log1p(k) / np.log1p(fine) for k in PUBLISHED)
    axes.fill_between(fine, low, high, color=PALE, linewidth=0, alpha=0.6)
    axes.plot(fine, np.log1p(EKMAN) / np.log1p(fine), color=GREY, label="Ekman's law, 0.03")
    for each in found.participants:
        axes.plot(
            [each.weber_fraction],
            [each.exponent],
            "o",
            color=BLUE,
            markersize=4,
            gid=tip(
                f"{each.participant}: exponent {each.exponent:.2f}, Weber fraction "
                f"{each.weber_fraction:.3f}"
            ),
        )
    axes.plot([], "o", color=BLUE, markersize=4, label="participants")
    x, y = found.weber_fraction, found.exponent
    axes.plot(list(x.interval), [y.value] * 2, color=VERMILION)
    axes.plot([x.value] * 2, list(y.interval), color=VERMILION, label="means with intervals")
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(base=10, subs=(1, 2, 5)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_xlim(fine[0], fine[-1])
    tops = [*own, *y.interval]
    axes.set_ylim(min(0.0, *tops) - 0.05, max(tops) * 1.25)
    axes.set_xlabel("Weber fraction")
    axes.set_ylabel("Exponent")
    axes.legend()
    return figure


class _ExponentAndWeber(TaskAnalysis):
    name = "exponent_and_weber"
    statistics = (EXPONENT_AND_WEBER,)

    def sentences(self, analysis: Analysis) -> Mapping[str, list[str]]:
        return {"Exponent and Weber fraction": _sentences(analysis)}

    def sections(self, analysis: Analysis, svgs: Mapping[str, str]) -> list[ReportSection]:
        return [section_of(analysis, svgs)]

    def figures(self, analysis: Analysis) -> Mapping[str, Figure]:
        return {
            f"exponent_and_weber_{one.task}": exponent_and_weber(one)
            for one in analysis.inference.found(EXPONENT_AND_WEBER) or ()
        }


ANALYSIS = _ExponentAndWeber()
