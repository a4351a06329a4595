"""The section on ratio judgements."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declaring import section_of
from slipscale.analysis.tasks.ratios import sentences as words
from slipscale.analysis.tasks.ratios.statistics import RATIOS
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import DASH, bracketed, significant

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.kind import Analysis
    from slipscale.analysis.tasks.ratios.statistics import TaskRatios


def ratios(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section of ratio judgements."""
    section = section_of("Ratio judgements", analysis)
    found = analysis.inference[RATIOS]
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
