"""The section on magnitude production."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declaring import section_of
from slipscale.analysis.tasks.productions import sentences as words
from slipscale.analysis.tasks.productions.statistics import PRODUCTIONS
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import DASH, bracketed, significant

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.kind import Analysis
    from slipscale.analysis.tasks.productions.statistics import TaskProductions


def productions(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section of magnitude production."""
    section = section_of("Magnitude production", analysis)
    found = analysis.inference[PRODUCTIONS]
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
