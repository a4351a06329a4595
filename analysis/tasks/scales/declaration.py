"""Declare scales from paired comparisons and triads."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import computed
from slipscale.analysis.tasks.declared.one_statistic import of_each, of_one_statistic
from slipscale.analysis.tasks.scales import figures, section, sentences, table
from slipscale.analysis.tasks.scales.reading import TRIALS
from slipscale.analysis.tasks.scales.statistics import SCALES

if TYPE_CHECKING:
    from slipscale.analysis.tasks.scales.statistics import TaskScale
    from slipscale.stimuli.quantity import Quantity


def _answers(found: tuple[TaskScale, ...], _level: float, quantity: Quantity) -> list[str]:
    return [sentences.scale_answer(task, quantity) for task in found]


ANALYSIS = of_one_statistic(
    "scales",
    TRIALS,
    SCALES,
    question="How do the {q.stimuli} lie on one scale of {q.judged}?",
    what="paired comparison",
    title="Paired comparison",
    answers=_answers,
    sentences=_answers,
    heading="Scales of {q.judged}",
    blocks=of_each(section.blocks),
    figures=lambda found, _, q: {
        f"scale_{each.task}": figures.scale(each, q)
        for each in found
        if any(map(computed, (each.bradley_terry, each.differences)))
    },
    table=table.scale_table,
)
