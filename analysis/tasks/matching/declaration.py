"""Define how the matching task is analysed and reported."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.declared.one_statistic import Blocks, Figures, OneStatistic, Svgs
from slipscale.analysis.tasks.declared.session_tables import mean_by_session
from slipscale.analysis.tasks.matching.statistics import MATCHING, TRIALS, MatchedReference
from slipscale.analysis.writing import html
from slipscale.analysis.writing.numbers import (
    bracketed,
    cell,
    counted,
    level_of,
    measured,
    number,
    p_value,
)
from slipscale.analysis.writing.task_names import task_name
from slipscale.analysis.writing.verdicts import DIFFERED, WERE_BIASED, Verb, verdict
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.figure_style import BLUE, GREY, INK, VERMILION, canvas, styled

if TYPE_CHECKING:
    import pandas as pd
    from markupsafe import Markup
    from matplotlib.figure import Figure

    from slipscale.analysis.json_form import JsonObject
    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants
    from slipscale.analysis.statistics.statistic import SessionTable
    from slipscale.analysis.tasks.kind import Analysis
    from slipscale.stimuli.quantity import Quantity


Task = list[MatchedReference]

#: First columns of the table: fields of `MatchedReference`. Tests of bias and direction follow.
TABULATED = (
    *("task", "reference_level", "matches", "participants", "mean_level", "variability_level"),
    *("ascending_level", "descending_level", "felt_again", "catch_trials", "catch_error_level"),
)


def _answer(found: MatchedReference, confidence: float, quantity: Quantity) -> str:
    written = measured(quantity)
    named = task_name("Matching", found.task)
    lead = "" if named == "Matching" else f"{named}: "
    what = (
        f"{lead}{quantity.with_convention(f'{found.reference_level:g}')} was matched by "
        f"{quantity.value(written(found.mean_level))} "
        f"({counted(found.matches, 'match', 'matches')} by "
        f"{counted(found.participants, 'participant', 'participants')})"
    )
    bias = found.bias_level
    if isinstance(bias, NotComputed):
        return f"{what}; the bias was not tested ({bias.reason})."

    def tested(verb: Verb, found: MeanOverParticipants) -> str:
        return (
            f"{verdict(verb, found.p, confidence, found.df)} "
            f"({quantity.value(written(found.mean))}, {level_of(confidence)} CI "
            f"{bracketed(found.interval, written)}, t({found.df}) = {number(found.t)}, "
            f"{p_value(found.p)})"
        )

    direction = found.direction_level
    start = (
        f" Matches that started above and below the reference {tested(DIFFERED, direction)}."
        if direction
        else ""
    )
    return f"{what}. Matches {tested(WERE_BIASED, bias)}.{start}"


def _matching_table(rows: Task, quantity: Quantity) -> Markup:
    def with_interval(found: MeanOverParticipants) -> str:
        return f"{written(found.mean)} {bracketed(found.interval, written)}"

    def tested(found: MeanOverParticipants | NotComputed) -> tuple[str, str]:
        return cell(found, with_interval), cell(found, lambda mean: p_value(mean.p))

    head, written = quantity.heading, measured(quantity)
    titles = [head("Reference"), "Matches", head("Mean"), head("Bias"), "p"]
    titles += [head("Within-participant SD"), head("Above minus below"), "p", "Repeats"]
    titles += ["Catch trials", head("Catch error")]
    return html.table(
        html.columns(*titles),
        [
            [
                number(each.reference_level),
                str(each.matches),
                written(each.mean_level),
                *tested(each.bias_level),
                written(each.variability_level),
                *tested(each.direction_level),
                number(each.felt_again),
                str(each.catch_trials),
                written(each.catch_error_level),
            ]
            for each in rows
        ],
        "Bias: mean match minus reference. Within-participant SD: root mean square of "
        "participants' standard deviations within a direction. Above minus below: difference "
        "between matches that started above and below the reference. Repeats: mean number of "
        "times that the reference was presented again per match. Catch error: mean distance from "
        "the reference in trials that started at the reference.",
    )


def _row(each: MatchedReference) -> JsonObject:
    row: JsonObject = {name: getattr(each, name) for name in TABULATED}
    for name, tested in (("bias", each.bias_level), ("direction", each.direction_level)):
        if tested:
            low, high = tested.interval
            row |= {
                f"{name}_level": tested.mean,
                f"{name}_ci_low": low,
                f"{name}_ci_high": high,
                f"{name}_p": tested.p,
            }
    return row


@styled
def matches(found: Sequence[MatchedReference], trials: pd.DataFrame, quantity: Quantity) -> Figure:
    """Plot matches against references, by direction of adjustment.

    Parameters
    ----------
    found : sequence of MatchedReference
        References of one task.
    trials : DataFrame
        Trials of the task, as read by `slipscale.analysis.tasks.matching.statistics.TRIALS`.
    quantity : Quantity
    """
    figure, axes = canvas(size=(5.6, 4.2))
    means = trials.groupby([PARTICIPANT, "reference_level", "direction"], observed=True)[
        "matched_level"
    ].mean()
    table = means.reset_index()
    ends = [
        min(each.reference_level for each in found),
        max(each.reference_level for each in found),
    ]
    margin = 0.08 * (ends[1] - ends[0] or ends[1])
    line = np.array([ends[0] - margin, ends[1] + margin])
    axes.plot(line, line, color=GREY, linewidth=0.9, linestyle=":", label="equal", zorder=0)
    for direction, colour, marker, shift in (
        ("ascending", BLUE, "^", -1),
        ("descending", VERMILION, "v", 1),
    ):
        own = table[table["direction"] == direction]
        axes.plot(
            own["reference_level"] + shift * 0.15 * margin,
            own["matched_level"],
            marker,
            color=colour,
            markersize=4,
            alpha=0.45,
            zorder=1,
        )
        points = [
            (each.reference_level, each.ascending_level if shift < 0 else each.descending_level)
            for each in found
        ]
        known = [(x, y) for x, y in points if y is not None]
        if known:
            axes.plot(
                *zip(*known, strict=True),
                marker=marker,
                color=colour,
                markersize=8,
                linewidth=0,
                markeredgecolor=INK,
                label=f"mean, {direction} (from {'below' if shift < 0 else 'above'})",
                zorder=3,
            )
    axes.set_xticks([each.reference_level for each in found])
    axes.set_xlabel(quantity.headed("Reference"))
    axes.set_ylabel(quantity.headed("Match"))
    figure.legend(loc="outside lower center", ncols=2)
    return figure


class _Matching(OneStatistic[Task]):
    name = "matching"
    trials = TRIALS
    statistics = (MATCHING,)
    question = "Which {q.level} feels the same as a reference?"
    what = "matching"
    title = "Matching"

    def tasks(self, analysis: Analysis) -> list[Task]:
        found = analysis.inference.found(MATCHING) or ()
        named = dict.fromkeys(each.task for each in found)
        return [[each for each in found if each.task == name] for name in named]

    def task_name(self, task: Task, _quantity: Quantity) -> str:
        return task_name("Matching", task[0].task)

    def task_answers(self, task: Task, confidence: float, quantity: Quantity) -> list[str]:
        return [_answer(each, confidence, quantity) for each in task]

    def task_remarks(self, task: Task, _confidence: float, _quantity: Quantity) -> list[str]:
        tested = sum(bool(each.bias_level) for each in task)
        if tested < 2:  # noqa: PLR2004 - nothing to correct
            return []
        text = (
            f"Bias and direction were each tested at {tested} references, without correction for "
            "several tests. Without any bias, about "
            f"{100 * (1 - 0.95**tested):.0f} % of studies have at least one p < .05."
        )
        return [text]

    def task_blocks(self, task: Task, svgs: Svgs, _percent: float, quantity: Quantity) -> Blocks:
        return [
            *html.figure_if_drawn(
                svgs,
                f"matching_{task[0].task}",
                "Matches against references, from below (blue, pointing up) and from above (red, "
                "pointing down). Small symbols: individual participants' means; large symbols: "
                "group means.",
                "Mean matches: "
                + ", ".join(
                    f"{each.mean_level:.3g} of {quantity.value(each.reference_level)}"
                    for each in task
                ),
            ),
            _matching_table(task, quantity),
        ]

    def task_figures(self, task: Task, trials: pd.DataFrame, quantity: Quantity) -> Figures:
        name = task[0].task
        return {f"matching_{name}": matches(task, trials[trials["task"] == name], quantity)}

    def task_rows(self, task: Task) -> list[JsonObject]:
        return [_row(each) for each in task]

    def session_tables(self, data: Dataset, _prepared: Prepared | None) -> Iterator[SessionTable]:
        return mean_by_session(
            data,
            TRIALS,
            "match minus reference",
            "{q.unit_in_short}",
            lambda rows: (rows["matched_level"] - rows["reference_level"]).astype(float),
        )


ANALYSIS = _Matching()
