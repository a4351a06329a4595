"""Render the report as a self-contained page."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import pandas as pd

from slipscale.analysis.reporting.sections.assumptions import assumptions
from slipscale.analysis.reporting.sections.methods import methods, normalisations
from slipscale.analysis.reporting.sections.multiplicity import tests_made
from slipscale.analysis.reporting.sections.plan import plan
from slipscale.analysis.reporting.sections.quality import quality
from slipscale.analysis.reporting.sections.summary import answers, summary
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing import html
from slipscale.experiments.dataset.schema import PARTICIPANT

#: Answers to a question are counted one by one if it has at most this many different answers.
ANSWERS_LISTED = 8
MODES = {"pilot": "pilot", "participant": "participants", "unknown": "not recorded"}


def render(analysis: Analysis, svgs: Mapping[str, str], software: Mapping[str, str]) -> str:
    """Return the report as HTML.

    Parameters
    ----------
    svgs : Mapping
        SVG elements as returned by `figure_style.svg`, keyed by figure name.
    software : Mapping
        Name -> version of the software used.
    """
    return html.page(
        "report.html",
        title=analysis.dataset.name,
        pilot=analysis.dataset.mode == "pilot",
        facts=facts(analysis),
        sections=sections(analysis, svgs, software),
    )


def facts(analysis: Analysis) -> list[tuple[str, str]]:
    """Return the key facts shown at the top of the report, as pairs of name and value."""
    data = analysis.dataset
    excluded = f" ({len(analysis.excluded)} excluded)" if analysis.excluded else ""
    people = len(analysis.flags) - len(analysis.excluded)
    found = [("Participants", f"{people}{excluded}")]
    if analysis.prepared is not None:
        found.append(("Normalisation", analysis.rule))
    # Data on other quantities come from other laboratories, and never from a pilot.
    if data.quantity.of_plate:
        found.append(("Data source", MODES.get(data.mode, data.mode)))
    found += [
        (title, ", ".join(data.details[key]))
        for key, title in (("study", "Study"), ("plate", "Plate"), ("language", "Language"))
        if key in data.details
    ]
    return found + about_participants(analysis)


def about_participants(analysis: Analysis) -> list[tuple[str, str]]:
    """Summarise the participants' answers to each question about themselves."""
    about = analysis.dataset.participants
    here = analysis.flags.index.difference(list(analysis.excluded))
    about = about[about[PARTICIPANT].astype(str).isin(here)].drop_duplicates(PARTICIPANT)
    found = []
    for name in about.columns.difference([PARTICIPANT, "mode", "complete"], sort=False):
        answers = about[name].dropna()
        if not len(answers):
            continue
        counts = answers.astype(str).value_counts().sort_index()
        title = str(name).replace("_", " ").capitalize()
        if pd.api.types.is_numeric_dtype(answers):
            low, high, mean = answers.min(), answers.max(), answers.mean()
            found.append((title, f"{low:g} to {high:g}, mean {mean:.1f}"))
        elif len(counts) <= ANSWERS_LISTED:
            found.append((title, ", ".join(f"{text} ({count})" for text, count in counts.items())))
    return found


def sections(
    analysis: Analysis, svgs: Mapping[str, str], software: Mapping[str, str]
) -> list[html.ReportSection]:
    """Return the page's sections in reading order, omitting empty sections."""
    of_kinds = [each for kind in analysis.kinds for each in kind.sections(analysis, svgs)]
    lead = [] if analysis.prepared is not None else _first_figure(of_kinds)
    # A section without blocks is not shown.
    stated = {text for section in of_kinds if section.blocks for text in section.gist}
    stated.update(answers(analysis))
    found = [
        summary(analysis, svgs, lead),
        plan(analysis),
        results(analysis, stated),
        *of_kinds,
        tests_made(analysis),
        assumptions(analysis, svgs),
        quality(analysis),
        normalisations(analysis),
        methods(analysis, software),
    ]
    for section in found:
        section.gist = list(map(_unbroken, section.gist))
    return html.numbered([section for section in found if section.blocks])


def _first_figure(found: Iterable[html.ReportSection]) -> list[html.Figure]:
    """Remove the first figure from its section, and return it in a list; empty without figures.

    A section that consists of a figure keeps it.
    """
    for section in found:
        if len(section.blocks) == 1:
            continue
        for place, block in enumerate(section.blocks):
            if isinstance(block, html.Figure):
                del section.blocks[place]
                return [block]
    return []


def conclusions(analysis: Analysis) -> dict[str, list[str]]:
    """Return the sentences for a results section, keyed by heading."""
    return {
        title: texts
        for kind in analysis.kinds
        for title, texts in kind.sentences(analysis).items()
        if texts
    }


def results(analysis: Analysis, stated: set[str]) -> html.ReportSection:
    """Return a section with the conclusions that other sections do not state.

    The summary states them with or without their heading.
    """
    further = {}
    for title, texts in conclusions(analysis).items():
        if rest := [text for text in texts if stated.isdisjoint((text, f"{title}: {text}"))]:
            further[title] = [html.paragraph(_unbroken(text), "sentence") for text in rest]
    section = html.ReportSection("Further results, in sentences", gist=[", ".join(further)])
    for title, blocks in further.items():
        section.blocks += [html.heading(title), *blocks]
    return section


def _unbroken(text: str) -> str:
    for sign in ("=", "<", ">"):
        text = text.replace(f" {sign} ", f"\N{NO-BREAK SPACE}{sign}\N{NO-BREAK SPACE}")
    return text
