"""Declare the method of limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declared.flat_table import flat_under
from slipscale.analysis.tasks.declared.one_statistic import of_each, of_one_statistic
from slipscale.analysis.tasks.limits.figures import transitions
from slipscale.analysis.tasks.limits.reading import TRIALS
from slipscale.analysis.tasks.limits.statistics import LIMITS
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import TableColumn
from slipscale.analysis.writing.numbers import (
    bracketed,
    counted,
    level_of,
    number,
    p_value,
    reliable,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.limits.statistics import TaskLimits
    from slipscale.stimuli.quantity import Quantity

HEADS = ("Ascending", "Descending", "Threshold", "Transitions")


def _answers(found: tuple[TaskLimits, ...], confidence: float, quantity: Quantity) -> list[str]:
    """Return one sentence per task: the threshold."""
    return [_threshold(task, confidence, quantity) for task in found]


def _threshold(task: TaskLimits, confidence: float, quantity: Quantity) -> str:
    threshold, named = task.threshold_um_pp, f"Method of limits ({task.task})"
    if isinstance(threshold, NotComputed):
        return f"{named}: no threshold, because there are {threshold.reason}."
    standard = task.standard_um_pp
    of = "" if standard is None else f" against a standard of {quantity.value(standard)}"
    return (
        f"{named}, {counted(task.series, 'series', 'series')} of "
        f"{counted(task.participants, 'participant', 'participants')}: the answer changed at "
        f"{quantity.value(f'{threshold.mean:.3g}')}{of}, {level_of(confidence)} CI "
        f"{bracketed(threshold.interval, lambda value: number(value, 3))}."
    )


def _sentences(found: tuple[TaskLimits, ...], confidence: float, quantity: Quantity) -> list[str]:
    """Return one paragraph per task, with the constant error."""
    return [
        " ".join([_threshold(task, confidence, quantity), *_remarks(task, confidence, quantity)])
        for task in found
    ]


def _remarks(task: TaskLimits, confidence: float, quantity: Quantity) -> list[str]:
    said, error = [], task.constant_error_um_pp
    if not isinstance(error, NotComputed):
        verb = "differed" if reliable(error.p, confidence) else "did not differ reliably"
        said.append(
            f"Descending and ascending series {verb}, by "
            f"{quantity.value(number(error.mean, 3))} (t({error.df}) = {number(error.t)}, "
            f"{p_value(error.p)})."
        )
    if task.without_transition:
        said.append(
            f"{task.without_transition} of {task.series} series have no transition and are "
            "left out."
        )
    return said


def _blocks(
    task: TaskLimits, svgs: Mapping[str, str], level: float, quantity: Quantity
) -> list[Markup]:
    """Return the figure and the table of one task."""
    rows = [
        [
            each.participant,
            number(each.ascending_um_pp, 3),
            number(each.descending_um_pp, 3),
            number(each.threshold_um_pp, 3),
            str(each.transitions),
        ]
        for each in task.people
    ]
    return [
        html.heading(task.task),
        *html.figure_if_drawn(
            svgs,
            f"limits_{task.task}",
            "Mean transitions of participants (pale) in ascending and descending series; blue: "
            f"means with a t-based {level:g} % interval.",
            "Mean transitions of ascending and descending series",
        ),
        html.table(
            [
                TableColumn(title="Participant", left=True),
                *(TableColumn(title=head) for head in HEADS),
            ],
            rows,
            f"Mean transitions in {quantity.unit}{quantity.behind}; the threshold is the mean of "
            "both directions.",
        ),
    ]


ANALYSIS = of_one_statistic(
    "limits",
    TRIALS,
    LIMITS,
    question="At which {q.level} does the answer change in series of {q.levels}?",
    what="the method of limits",
    title="Method of limits",
    answers=_answers,
    sentences=_sentences,
    blocks=of_each(_blocks),
    figures=lambda found, _trials, q: {
        f"limits_{each.task}": transitions(each, q) for each in found
    },
    table=lambda found: flat_under(
        [({"task": task.task}, each) for task in found for each in task.people]
    ),
)
