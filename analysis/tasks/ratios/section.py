"""Write the section on ratio judgements."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.tasks.ratios import sentences as words
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import TableColumn
from slipscale.analysis.writing.numbers import bracketed, significant

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.ratios.statistics import TaskRatios
    from slipscale.stimuli.quantity import Quantity


def blocks(
    task: TaskRatios, svgs: Mapping[str, str], level: float, quantity: Quantity
) -> list[Markup]:
    """Return the blocks of one task: its figures and tables."""
    return [
        html.heading(words.ratio_title(task, quantity)),
        *html.figure_if_drawn(
            svgs,
            f"ratios_{task.name}",
            "Ratios to the standard, on logarithmic axes. Pale: each participant's "
            "geometric means; blue: their geometric mean with a t-based "
            f"{level:g} % interval, and the power function through them; black: the "
            "standard, 1 by definition.",
            "Geometric mean ratios: "
            + ", ".join(
                f"{quantity.value(each.comparison_um_pp)}: {each.ratio:.3g}"
                for each in task.surfaces
            ),
        ),
        _ratio_table(task, quantity),
    ]


def _ratio_table(task: TaskRatios, quantity: Quantity) -> Markup:
    titles = (quantity.heading(quantity.title), "Participants", "Judgements", "Ratio", "CI")
    return html.table(
        [TableColumn(title=title) for title in titles],
        [
            [
                f"{each.comparison_um_pp:g}",
                str(each.participants),
                str(each.judgements),
                significant(each.ratio),
                bracketed(each.interval, significant),
            ]
            for each in task.surfaces
        ],
        f"How many times as {quantity.adjective} as the standard "
        f"({quantity.value(task.standard_um_pp)}{quantity.behind}): "
        "geometric mean of participants' geometric means, with a t-based interval on logarithms.",
    )
