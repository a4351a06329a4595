"""Declare same–different trials."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING

import pandas as pd

from slipscale.analysis.tasks.declared.one_statistic import of_each, of_one_statistic
from slipscale.analysis.tasks.same_different.figures import sensitivities
from slipscale.analysis.tasks.same_different.reading import TRIALS
from slipscale.analysis.tasks.same_different.statistics import SAME_DIFFERENT, PairSensitivity
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import TableColumn
from slipscale.analysis.writing.numbers import bracketed, cell, counted, number

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.same_different.statistics import TaskPairs
    from slipscale.stimuli.quantity import Quantity

HEADS = (
    *("Participants", "Different, called different", "Same, called different"),
    *("d'", "Criterion k", "Mean d'", "CI"),
)


def _sentences(found: tuple[TaskPairs, ...], _confidence: float, _quantity: Quantity) -> list[str]:
    """Return one sentence per task: d' of each pair."""
    return [
        f"Same–different ({task.task}), {counted(task.answers, 'answer', 'answers')} of "
        f"{counted(task.participants, 'participant', 'participants')}: d' by the differencing "
        "model was "
        + ", ".join(
            f"{number(each.d_prime)} ({each.first} and {each.second})" for each in task.pairs
        )
        + "."
        for task in found
    ]


def _blocks(
    task: TaskPairs, svgs: Mapping[str, str], level: float, quantity: Quantity
) -> list[Markup]:
    """Return the figure and the table of one task."""
    rows = [
        [
            f"{each.first} – {each.second}",
            str(each.participants),
            f"{each.different} of {each.different_n}",
            f"{each.same} of {each.same_n}",
            number(each.d_prime),
            number(each.criterion),
            cell(each.mean_d_prime, lambda mean: number(mean.mean)),
            cell(each.mean_d_prime, lambda mean: bracketed(mean.interval)),
        ]
        for each in task.pairs
    ]
    return [
        html.heading(task.task),
        *html.figure_if_drawn(
            svgs,
            f"same_different_{task.task}",
            f"Mean d' of participants with a t-based {level:g} % interval; crosses: d' of all "
            "answers together. A pair with d' = 0 is not told apart.",
            "d' of " + ", ".join(f"{each.first} and {each.second}" for each in task.pairs),
        ),
        html.table(
            [TableColumn(title="Pair", left=True), *(TableColumn(title=head) for head in HEADS)],
            rows,
            f"Pairs of {quantity.stimuli}. d' and k are in standard deviations of one "
            "impression: two impressions further apart than k are called different.",
        ),
    ]


def _table(found: tuple[TaskPairs, ...]) -> pd.DataFrame:
    own = [field.name for field in fields(PairSensitivity) if field.name != "mean_d_prime"]
    return pd.DataFrame(
        [
            {"task": task.task} | {name: getattr(each, name) for name in own}
            for task in found
            for each in task.pairs
        ]
    )


ANALYSIS = of_one_statistic(
    "same_different",
    TRIALS,
    SAME_DIFFERENT,
    question="Which pairs of {q.stimuli} are told apart?",
    what="same–different",
    title="Same–different",
    answers=_sentences,
    sentences=_sentences,
    blocks=of_each(_blocks),
    figures=lambda found, _trials, _q: {
        f"same_different_{each.task}": sensitivities(each) for each in found
    },
    table=_table,
)
