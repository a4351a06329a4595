"""Ratings on a line, ratio judgements and magnitude production: figure and table of each task."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reporting import apa_magnitude_modes as words
from slipscale.analysis.reporting import html
from slipscale.analysis.reporting.html import ReportSection, TableColumn
from slipscale.analysis.reporting.numbers import DASH, bracketed, number, p_value, significant
from slipscale.analysis.statistics.not_computed import NotComputed

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.result import Analysis
    from slipscale.analysis.statistics.productions import TaskProductions
    from slipscale.analysis.statistics.ratings import TaskRatings
    from slipscale.analysis.statistics.ratio_judgements import TaskRatios


def ratings(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section of ratings on a line."""
    section = _section("Ratings on a visual analogue scale", analysis)
    found = analysis.inference.ratings
    level = 100 * analysis.dataset.choices.confidence
    for task in () if isinstance(found, NotComputed) else found:
        section.blocks.append(html.heading(words.rating_title(task)))
        if (svg := svgs.get(f"ratings_{task.task}")) is not None:
            section.blocks.append(
                html.figure(
                    svg,
                    "Places on the line, from its left end (0) to its right (100). Pale: each "
                    f"participant's means; blue: their mean with Student's {level:g} % interval.",
                    "Mean ratings: "
                    + ", ".join(f"{each.surface}: {each.mean:.0f}" for each in task.surfaces),
                )
            )
        section.blocks += [_rating_table(task), _pair_table(task)]
    return section


def ratios(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section of ratio judgements."""
    section = _section("Ratio judgements", analysis)
    found = analysis.inference.ratios
    level = 100 * analysis.dataset.choices.confidence
    for task in () if isinstance(found, NotComputed) else found:
        section.blocks.append(html.heading(words.ratio_title(task)))
        if (svg := svgs.get(f"ratios_{task.name}")) is not None:
            section.blocks.append(
                html.figure(
                    svg,
                    "Ratios to the standard, on logarithmic axes. Pale: each participant's "
                    "geometric means; blue: their geometric mean with Student's "
                    f"{level:g} % interval, and the power function through them; black: the "
                    "standard, 1 by definition.",
                    "Geometric mean ratios: "
                    + ", ".join(
                        f"{each.comparison_um_pp:g} µm: {each.ratio:.3g}" for each in task.surfaces
                    ),
                )
            )
        section.blocks.append(_ratio_table(task))
    return section


def productions(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section of magnitude production."""
    section = _section("Magnitude production", analysis)
    found = analysis.inference.productions
    level = 100 * analysis.dataset.choices.confidence
    for task in () if isinstance(found, NotComputed) else found:
        section.blocks.append(html.heading(words.production_title(task)))
        if (svg := svgs.get(f"productions_{task.task}")) is not None:
            section.blocks.append(
                html.figure(
                    svg,
                    "Amplitudes produced for the numbers shown, on logarithmic axes. Pale: each "
                    "participant's geometric means; blue: their geometric mean with Student's "
                    f"{level:g} % interval, and the line whose slope is the exponent's inverse; "
                    "black: the standard and its number.",
                    "Geometric mean amplitudes: "
                    + ", ".join(
                        f"{each.number:g}: {each.amplitude_um_pp:.3g} µm" for each in task.numbers
                    ),
                )
            )
        section.blocks.append(_production_table(task))
        if isinstance(task.both, NotComputed):
            section.blocks.append(
                html.paragraph(
                    f"Not beside an exponent of estimation: {task.both.reason}. Production alone "
                    "has a bias of its own; a task of magnitude_estimation in the same study shows "
                    "it.",
                    "note",
                )
            )
    return section


def _section(title: str, analysis: Analysis) -> ReportSection:
    return ReportSection(title, shown="closed" if analysis.prepared is not None else "open")


def _rating_table(task: TaskRatings) -> Markup:
    titles = ("Ratings", "Mean", "CI", "SD", "At the left end", "At the right end")
    columns = [TableColumn(title="Surface", left=True), *(TableColumn(title=t) for t in titles)]
    rows = [
        [
            each.surface,
            str(each.ratings),
            number(each.mean, 1),
            DASH if each.interval is None else bracketed(each.interval, _one),
            number(each.sd, 1),
            str(each.at_left),
            str(each.at_right),
        ]
        for each in task.surfaces
    ]
    return html.table(
        columns,
        rows,
        "Places on the line, 0 to 100; amplitudes in µm, peak to peak. Mean, Student's interval "
        "and standard deviation of one value a participant.",
    )


def _pair_table(task: TaskRatings) -> Markup:
    columns = [
        TableColumn(title="From", left=True),
        TableColumn(title="To", left=True),
        *(TableColumn(title=title) for title in ("n", "Difference", "CI", "p (Wilcoxon, Holm)")),
    ]
    rows = []
    for pair in task.pairs:
        found = pair.difference
        untold = isinstance(found, NotComputed)
        rows.append(
            [
                pair.from_surface,
                pair.to_surface,
                str(pair.participants),
                DASH if isinstance(found, NotComputed) else number(found.mean, 1),
                DASH if isinstance(found, NotComputed) else bracketed(found.interval, _one),
                DASH if untold else p_value(pair.p_wilcoxon_holm),
            ]
        )
    return html.table(
        columns,
        rows,
        "Differences of mean places, with Student's interval; Wilcoxon's signed-rank test of each "
        "pair, Holm-corrected over all pairs of the task.",
    )


def _ratio_table(task: TaskRatios) -> Markup:
    titles = ("Amplitude (µm)", "Participants", "Judgements", "Ratio", "CI")
    return html.table(
        [TableColumn(title=title) for title in titles],
        [
            [
                f"{each.comparison_um_pp:g}",
                str(each.participants),
                str(each.judgements),
                significant(each.ratio),
                DASH if each.interval is None else bracketed(each.interval, significant),
            ]
            for each in task.surfaces
        ],
        f"How many times as slippery as the standard ({task.standard_um_pp:g} µm, peak to peak): "
        "geometric mean of participants' geometric means, with Student's interval on logarithms.",
    )


def _production_table(task: TaskProductions) -> Markup:
    titles = ("Number", "Participants", "Productions", "Amplitude (µm)", "CI")
    return html.table(
        [TableColumn(title=title) for title in titles],
        [
            [
                f"{each.number:g}",
                str(each.participants),
                str(each.productions),
                significant(each.amplitude_um_pp),
                DASH if each.interval is None else bracketed(each.interval, significant),
            ]
            for each in task.numbers
        ],
        f"Amplitudes (peak to peak) produced for each number, where the standard of "
        f"{task.standard_um_pp:g} µm is called {task.modulus:g}: geometric mean of participants' "
        "geometric means, with Student's interval on logarithms.",
    )


def _one(value: float) -> str:
    return number(value, 1)
