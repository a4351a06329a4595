"""Write the section on magnitude production."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import fold
from slipscale.analysis.tasks.productions import sentences as words
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import TableColumn
from slipscale.analysis.writing.numbers import bracketed, significant

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.productions.statistics import TaskProductions


def blocks(
    tasks: tuple[TaskProductions, ...], svgs: Mapping[str, str], level: float
) -> list[Markup]:
    """Return the section of magnitude production."""
    return [block for task in tasks for block in _task(task, svgs, level)]


def _task(task: TaskProductions, svgs: Mapping[str, str], level: float) -> list[Markup]:
    return [
        html.heading(words.production_title(task)),
        *html.figure_if_drawn(
            svgs,
            f"productions_{task.task}",
            "Amplitudes produced for the numbers shown, on logarithmic axes. Pale: each "
            "participant's geometric means; blue: their geometric mean with Student's "
            f"{level:g} % interval, and the line whose slope is the exponent's inverse; "
            "black: the standard and its number.",
            "Geometric mean amplitudes: "
            + ", ".join(f"{each.number:g}: {each.amplitude_um_pp:.3g} µm" for each in task.numbers),
        ),
        _production_table(task),
        *fold(task.both, lambda _: [], _alone),
    ]


def _alone(reason: str) -> list[Markup]:
    return [
        html.paragraph(
            f"Not beside an exponent of estimation: {reason}. Production alone has a bias of its "
            "own; a task of magnitude_estimation in the same study shows it.",
            "note",
        )
    ]


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
                bracketed(each.interval, significant),
            ]
            for each in task.numbers
        ],
        f"Amplitudes (peak to peak) produced for each number, where the standard of "
        f"{task.standard_um_pp:g} µm is called {task.modulus:g}: geometric mean of participants' "
        "geometric means, with Student's interval on logarithms.",
    )
