"""Write the summary with the question, the design, the answer, a figure and caveats."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from markupsafe import Markup

from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.axes import LINES_AT_MOST
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import counted, grouped
from slipscale.stimuli.quantity import capitalised

#: With fewer participants than this, the summary warns about wide intervals.
SMALL = 6
#: Largest number of caveats shown in the summary; the others are in an expandable list.
DOUBTS_SHOWN = 8


def summary(analysis: Analysis, svgs: Mapping[str, str], lead: Sequence[Markup]) -> ReportSection:
    """Return the summary section.

    Parameters
    ----------
    lead : sequence of Markup
        The figure that follows the plain answers, if magnitude estimation does not provide it.
    """
    section = ReportSection("Summary", shown="always")
    section.blocks.append(html.labelled("Question", _question(analysis)))
    plain = [text for kind in analysis.kinds for text in kind.plain_answers(analysis)]
    section.blocks += _sentences("Answer", plain)
    if "fig15" in svgs and analysis.prepared is not None:
        section.blocks.append(_figure(analysis, svgs["fig15"]))
    section.blocks += lead
    for kind in analysis.kinds:
        rest = [text for text in kind.answers(analysis) if text not in plain]
        section.blocks += [html.paragraph(text) for text in rest]
        section.blocks += _caveats(kind.doubts(analysis))
    if doubts := _doubts(analysis):
        section.blocks += [html.heading("Caveats"), *_caveats(doubts)]
    section.blocks.append(html.labelled("Design", _design(analysis)))
    return section


def _sentences(label: str, texts: Sequence[str]) -> list[Markup]:
    """Return paragraphs, the first of which has a label."""
    return [
        html.paragraph(text) if place else html.labelled(label, text)
        for place, text in enumerate(texts)
    ]


def _caveats(doubts: Sequence[str]) -> list[Markup]:
    """Return a list of caveats; those after the first `DOUBTS_SHOWN` can be expanded."""
    shown, more = doubts[:DOUBTS_SHOWN], doubts[DOUBTS_SHOWN:]
    found = [html.bullets(shown, "problem")] if shown else []
    return found + ([html.details(f"{len(more)} more", [html.bullets(more)])] if more else [])


def answers(analysis: Analysis) -> list[str]:
    """Return one or two sentences on the main result for each task."""
    return [text for kind in analysis.kinds for text in kind.answers(analysis)]


def _question(analysis: Analysis) -> str:
    return " ".join(question for kind in analysis.kinds for question in kind.questions(analysis))


def _design(analysis: Analysis) -> str:
    people = len(analysis.flags) - len(analysis.excluded)
    parts = [counted(people, "participant", "participants")]
    parts += [part for kind in analysis.kinds for part in kind.design(analysis)]
    return "; ".join(parts) + "."


def _doubts(analysis: Analysis) -> list[str]:
    """Return the caveats about all results, starting with the most serious one."""
    found = []
    people = len(analysis.flags) - len(analysis.excluded)
    if 2 < people < SMALL:  # noqa: PLR2004 - fewer participants have their own message
        found.append(
            f"There are only {people} participants: intervals are wide, and a non-significant "
            "difference is not evidence of equality."
        )
    if analysis.prepared is not None and analysis.prepared.zeros:
        found.append(analysis.prepared.zero_sentence)
    found += analysis.problems
    flagged = int(analysis.flags.any(axis=1).sum())
    if flagged:
        found.append(
            f"{flagged} of {len(analysis.flags)} participants showed an unusual response pattern. "
            "The section “Participants and data quality” lists these participants and shows the "
            "main results without them."
        )
    return found


def _figure(analysis: Analysis, svg: str) -> Markup:
    quantity, people = analysis.dataset.quantity, len(analysis.cells)
    ns = analysis.description["n"]
    counts = " to ".join(f"{n}" for n in sorted({int(ns.min()), int(ns.max())}))
    means = analysis.description[["level", "mean"]].itertuples(index=False)
    bars = (
        f" Error bars: t-based {100 * analysis.dataset.choices.confidence:g} % confidence intervals"
        " across participants, which end at possible means."
        if analysis.description["mean_low"].notna().any()
        else ""
    )
    each = "individual participants" if people <= LINES_AT_MOST else "range of participants"
    who = (
        "Estimates of a single participant, so no spread or intervals are shown."
        if people == 1
        else f"Arithmetic means of {counts} participants.{bars} Thin lines: {each}."
    )
    if analysis.beside_paper:
        who += " Diamonds: the paper’s means, with one standard deviation."
    return html.figure(
        svg,
        f"{capitalised(quantity.perceived)} against {quantity.in_full}. {who} "
        f"Normalisation: {analysis.rule}.",
        f"Line chart of mean {quantity.judged}, with these values: "
        + ", ".join(f"{grouped(mean, 1)} at {quantity.value(level)}" for level, mean in means),
    )
