"""Write the section on magnitude production."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import fold
from slipscale.analysis.tasks.productions import sentences as words
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import TableColumn
from slipscale.analysis.writing.numbers import bracketed, significant
from slipscale.stimuli.quantity import capitalised

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.productions.statistics import TaskProductions
    from slipscale.stimuli.quantity import Quantity


def blocks(
    task: TaskProductions, svgs: Mapping[str, str], level: float, quantity: Quantity
) -> list[Markup]:
    """Return the blocks of one task: its figures and tables."""
    levels = quantity.levels
    return [
        html.heading(words.production_title(task)),
        *html.figure_if_drawn(
            svgs,
            f"productions_{task.task}",
            f"{capitalised(levels)} produced for the numbers shown, on logarithmic axes. Pale: "
            "each participant's geometric means; blue: their geometric mean with a t-based "
            f"{level:g} % interval, and the line whose slope is the exponent's inverse; "
            "black: the standard and its number.",
            f"Geometric mean {levels}: "
            + ", ".join(
                f"{each.number:g}: {quantity.value(f'{each.amplitude_um_pp:.3g}')}"
                for each in task.numbers
            ),
        ),
        _production_table(task, quantity),
        *fold(task.both, lambda _: [], _alone),
    ]


def _alone(reason: str) -> list[Markup]:
    return [
        html.paragraph(
            f"Not compared with an exponent of estimation: {reason}. Production alone is "
            "biased; add a magnitude_estimation task to the study to measure the bias.",
            "note",
        )
    ]


def _production_table(task: TaskProductions, quantity: Quantity) -> Markup:
    convention = f" ({quantity.convention})" if quantity.convention else ""
    level = quantity.heading(quantity.title)
    titles = ("Number", "Participants", "Productions", level, "CI")
    return html.table(
        [TableColumn(title=title) for title in titles],
        [
            [
                f"{each.number:g}",
                str(each.participants),
                str(each.productions),
                significant(each.amplitude_um_pp),
                bracketed(each.interval, significant),
            ]
            for each in task.numbers
        ],
        f"{capitalised(quantity.levels)}{convention} produced for each number, if the "
        f"standard of {quantity.value(task.standard_um_pp)} is called {task.modulus:g}: "
        "geometric mean of participants' geometric means, with a t-based interval on "
        "logarithms.",
    )
