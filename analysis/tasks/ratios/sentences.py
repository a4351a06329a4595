"""Write sentences on ratio judgements."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.writing.numbers import (
    bracketed,
    counted,
    level_of,
    number,
    significant,
)

if TYPE_CHECKING:
    from slipscale.analysis.tasks.ratios.statistics import TaskRatios
    from slipscale.stimuli.quantity import Quantity


def ratio_title(found: TaskRatios, quantity: Quantity) -> str:
    """Return the name of a task in the report."""
    return f"Ratio judgements against {quantity.value(found.standard_um_pp)} ({found.task})"


def ratio_answer(found: TaskRatios, confidence: float, quantity: Quantity) -> str:
    """Return the main sentence on ratio judgements."""
    what = (
        f"{ratio_title(found, quantity)}, {counted(found.answers, 'judgement', 'judgements')} of "
        f"{counted(found.participants, 'participant', 'participants')}"
    )
    law = found.power_law
    if isinstance(law, NotComputed):
        return f"{what}: no exponent ({law.reason})."
    return (
        f"{what}: the exponents of participants' power functions of {quantity.name} averaged "
        f"{number(law.exponent)}, {level_of(confidence)} CI {bracketed(law.interval)} "
        f"(n = {law.n}; {law.points} {quantity.levels} above {quantity.value(0)})."
    )


def ratio_sentences(
    found: tuple[TaskRatios, ...], confidence: float, quantity: Quantity
) -> list[str]:
    """Return one paragraph per task of ratio judgements."""
    return [
        f"{ratio_answer(task, confidence, quantity)} {_ratios(task, confidence, quantity)}"
        for task in found
    ]


def _ratios(found: TaskRatios, confidence: float, quantity: Quantity) -> str:
    each = "; ".join(
        f"{quantity.value(one.comparison_um_pp)} {significant(one.ratio)} times"
        + ("" if one.interval is None else f", {bracketed(one.interval, significant)}")
        for one in found.surfaces
    )
    text = (
        f"As {quantity.adjective} as the standard (geometric means, {level_of(confidence)} CI of "
        f"participants' mean logarithms): {each}."
    )
    if found.catch_ratio is None:
        return text
    return (
        f"{text} The standard itself was judged {significant(found.catch_ratio)} times as "
        f"{quantity.adjective} ({counted(found.catch_trials, 'catch trial', 'catch trials')}; "
        "correct: 1)."
    )
