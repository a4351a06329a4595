"""What is read in two minutes: question, design, answer, one figure, and what to doubt."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.figures.shared import LINES_AT_MOST
from slipscale.analysis.preprocessing import normalisation
from slipscale.analysis.reporting import (
    apa,
    apa_difference,
    apa_magnitude_modes,
    apa_scales,
    apa_thresholds,
    html,
)
from slipscale.analysis.reporting.html import ReportSection
from slipscale.analysis.reporting.numbers import counted, grouped
from slipscale.analysis.statistics.not_computed import NotComputed

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.result import Analysis

#: Fewer participants than this make every interval wide and every "not told apart" empty.
SMALL = 6
#: What to doubt is shown to this many; the rest is in the sections concerned.
DOUBTS_SHOWN = 8


def summary(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the summary."""
    section = ReportSection("Summary", shown="always")
    doubts = _doubts(analysis)
    if analysis.prepared is not None and analysis.prepared.zeros:
        section.blocks.append(html.paragraph(analysis.prepared.zero_sentence, "problem"))
    section.blocks += [
        html.labelled("Question", _question(analysis)),
        html.labelled("Design", _design(analysis)),
    ]
    answer = " ".join(answers(analysis))
    section.blocks.append(html.labelled("Answer", answer))
    if "fig15" in svgs and analysis.prepared is not None:
        section.blocks.append(_figure(analysis, svgs["fig15"]))
    if doubts:
        section.blocks.append(html.heading("What to doubt"))
        section.blocks.append(html.bullets(doubts[:DOUBTS_SHOWN], "problem"))
        if len(doubts) > DOUBTS_SHOWN:
            section.blocks.append(
                html.details(
                    f"{len(doubts) - DOUBTS_SHOWN} more", [html.bullets(doubts[DOUBTS_SHOWN:])]
                )
            )
    return section


def answers(analysis: Analysis) -> list[str]:
    """Return the chief result of every task, a sentence or two each: what the data answer."""
    choices = analysis.dataset.choices
    found: list[str] = []
    if analysis.prepared is not None:
        found += apa.primary_sentences(analysis.inference, choices.primary, choices.confidence)
        found += _equal(analysis)
        if not isinstance(analysis.inference.power_law, NotComputed):
            found.append(apa.power_law(analysis.inference.power_law, choices.confidence))
    felt = analysis.inference.difference
    if not isinstance(felt, NotComputed):
        found += apa_difference.answer(
            felt, choices.confidence, of_plate=analysis.dataset.quantity.of_plate
        )
    limits = analysis.inference.thresholds
    if not isinstance(limits, NotComputed):
        found += [apa_thresholds.answer(task, choices.confidence) for task in limits]
    compared, matched = analysis.inference.scales, analysis.inference.matching
    if not isinstance(compared, NotComputed):
        found += [apa_scales.scale_answer(task) for task in compared]
    found += apa_scales.matching_sentences(matched, choices.confidence)
    found += _magnitudes(analysis)
    return found


def _magnitudes(analysis: Analysis) -> list[str]:
    """Return the chief sentences of ratings on a line, ratio judgements and production."""
    inference, level = analysis.inference, analysis.dataset.choices.confidence
    rated, judged, produced = inference.ratings, inference.ratios, inference.productions
    answers: list[str] = []
    if not isinstance(rated, NotComputed):
        answers += [apa_magnitude_modes.rating_answer(task) for task in rated]
    if not isinstance(judged, NotComputed):
        answers += [apa_magnitude_modes.ratio_answer(task, level) for task in judged]
    for task in () if isinstance(produced, NotComputed) else produced:
        answers += apa_magnitude_modes.production_answers(task, level)
    return answers


def _equal(analysis: Analysis) -> list[str]:
    """Return the sentence on pairs that were shown to be equal, where there are any."""
    pairs, level = analysis.inference.pairwise, analysis.dataset.choices.confidence
    if isinstance(pairs, NotComputed) or not any(
        apa.reliable(pair.logs.equivalence_p_holm, level)
        for pair in pairs
        if not isinstance(pair.logs, NotComputed)
    ):
        return []
    text = apa.equivalence(pairs, level)
    return [text] if text else []


def _question(analysis: Analysis) -> str:
    parts = []
    if analysis.prepared is not None:
        parts.append("Does perceived slipperiness change with vibration amplitude, and how?")
    if not isinstance(analysis.inference.difference, NotComputed):
        parts.append("Do participants feel a step down in amplitude, and what do they say of it?")
    if not isinstance(analysis.inference.thresholds, NotComputed):
        parts.append("How small an amplitude, or a change of it, is felt?")
    if not isinstance(analysis.inference.scales, NotComputed):
        parts.append("How do the surfaces lie on one scale of slipperiness?")
    if not isinstance(analysis.inference.matching, NotComputed):
        parts.append("Which amplitude feels the same as a reference?")
    if not isinstance(analysis.inference.ratings, NotComputed):
        parts.append("Where on a line between two words do the surfaces lie?")
    if not isinstance(analysis.inference.ratios, NotComputed):
        parts.append("How many times as slippery as a standard is each surface?")
    if not isinstance(analysis.inference.productions, NotComputed):
        parts.append("Which amplitudes are as slippery as given numbers?")
    return " ".join(parts)


def _design(analysis: Analysis) -> str:
    people = len(analysis.flags) - len(analysis.excluded)
    parts = [counted(people, "participant", "participants")]
    if analysis.prepared is not None:
        amplitudes = ", ".join(f"{a:g}" for a in analysis.cells.columns)
        trials = counted(len(analysis.estimates), "estimate", "estimates")
        parts.append(f"{trials} of {amplitudes} µm (peak to peak)")
    felt = analysis.inference.difference
    if not isinstance(felt, NotComputed):
        steps = sum(step.n for step in felt.steps)
        parts.append(
            f"{counted(steps, 'step', 'steps')} down and "
            f"{counted(felt.catch.n, 'catch step', 'catch steps')}"
        )
    data = analysis.dataset
    for rows, what in (
        (data.forced_choices, "forced choice"),
        (data.comparisons, "paired comparison"),
        (data.matches, "matching"),
        (data.ratings, "a visual analogue scale"),
        (data.ratios, "ratio judgement"),
        (data.productions, "magnitude production"),
    ):
        if len(rows):
            parts.append(f"{counted(len(rows), 'trial', 'trials')} of {what}")
    return "; ".join(parts) + "."


def _doubts(analysis: Analysis) -> list[str]:
    """Return what a careful reader would hold against the answer, the gravest first."""
    found = []
    people = len(analysis.flags) - len(analysis.excluded)
    if 2 < people < SMALL:  # noqa: PLR2004 - of one or two, what is missing is told
        found.append(
            f"{people} participants: intervals are wide, and what is not told apart may differ."
        )
    order = analysis.inference.order
    if isinstance(order, NotComputed) and "not identifiable" in order.reason:
        found.append(f"Effects of order are {order.reason}.")
    found += analysis.problems
    flagged = int(analysis.flags.any(axis=1).sum())
    if flagged:
        found.append(
            f"{flagged} of {len(analysis.flags)} participants carry a flag of data quality; the "
            "chief results without them stand under Participants and data quality."
        )
    felt = analysis.inference.difference
    if not isinstance(felt, NotComputed) and isinstance(felt.signal_detection, NotComputed):
        found.append(f"Sensitivity was not computed: {felt.signal_detection.reason}.")
    return found


def _figure(analysis: Analysis, svg: str) -> Markup:
    rule = normalisation.RULES[analysis.rule]
    return html.figure(
        svg,
        f"Perceived slipperiness against vibration amplitude. {_lines(analysis)} "
        f"Normalisation: {analysis.rule} ({rule.formula}).",
        "Line chart of mean slipperiness: "
        + ", ".join(
            f"{grouped(mean, 1)} at {amplitude:g} µm"
            for amplitude, mean in analysis.cells.mean().items()
        ),
    )


def _lines(analysis: Analysis) -> str:
    """Say what Fig. 15 shows of so many participants."""
    people = len(analysis.cells)
    if people == 1:
        return "One participant's means: no spread and no intervals."
    level = 100 * analysis.dataset.choices.confidence
    intervals = (
        f" Bars: geometric means with {level:g} % within-participant confidence intervals "
        "(Cousineau-Morey on logarithms), where nobody's estimate is zero."
        if analysis.description["within_low"].notna().any()
        else ""
    )
    each = "each participant's means" if people <= LINES_AT_MOST else "where participants lie"
    return f"Blue: means of {people} participants. Pale: {each}.{intervals}"
