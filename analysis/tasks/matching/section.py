"""Write the section on matching."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import TableColumn
from slipscale.analysis.writing.numbers import bracketed, cell, measured, number, p_value

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants
    from slipscale.analysis.statistics.not_computed import NotComputed
    from slipscale.analysis.tasks.matching.statistics import MatchedReference
    from slipscale.stimuli.quantity import Quantity


def blocks(
    found: tuple[MatchedReference, ...], svgs: Mapping[str, str], _level: float, quantity: Quantity
) -> list[Markup]:
    """Return the section of matching: figure, and one row per reference."""
    written = []
    for task in sorted({each.task for each in found}):
        rows = [each for each in found if each.task == task]
        written += html.figure_if_drawn(
            svgs,
            f"matching_{task}",
            "Matches against references, from below (blue, pointing up) and from above (red, "
            "pointing down). Small: participants' means; large: their means.",
            "Mean matches: "
            + ", ".join(
                f"{each.mean_um_pp:.3g} of {quantity.value(each.reference_um_pp)}" for each in rows
            ),
        )
        written.append(_matching_table(rows, quantity))
    return written


def _matching_table(rows: list[MatchedReference], quantity: Quantity) -> Markup:
    def with_interval(found: MeanOverParticipants) -> str:
        return f"{written(found.mean)} {bracketed(found.interval, written)}"

    def tested(found: MeanOverParticipants | NotComputed) -> tuple[str, str]:
        return cell(found, with_interval), cell(found, lambda mean: p_value(mean.p))

    head, written = quantity.heading, measured(quantity)
    titles = [head("Reference"), "Matches", head("Mean"), head("Bias"), "p", head("Own SD")]
    titles += [head("Above less below"), "p", "Repeated", "Catch trials", head("Catch error")]
    columns = [TableColumn(title=title) for title in titles]
    return html.table(
        columns,
        [
            [
                number(each.reference_um_pp),
                str(each.matches),
                written(each.mean_um_pp),
                *tested(each.bias_um_pp),
                written(each.variability_um_pp),
                *tested(each.direction_um_pp),
                number(each.felt_again),
                str(each.catch_trials),
                written(each.catch_error_um_pp),
            ]
            for each in rows
        ],
        "Bias: mean match minus reference. Own SD: root mean square of participants' standard "
        "deviations within a direction. Above less below: matches from above minus matches from "
        "below. Repeated: how often the reference was presented again per match. Catch error: "
        "mean distance from the reference in trials that began at it.",
    )
