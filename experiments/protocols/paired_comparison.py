"""Paired comparison: the participant chooses the more slippery surface of each pair.

With ``triads``, three surfaces are presented in rising or falling order, and the participant judges
which of the two steps between them is larger. These judgements give a difference scale (Maloney and
Yang 2003, Journal of Vision 3(8):5). Pairs include the study's textures; triads do not,
because textures cannot be ordered.
"""

from __future__ import annotations

from itertools import combinations
from typing import Literal

from slipscale.experiments.languages.texts import answers
from slipscale.experiments.protocol_parts.base import AtLeastOne, Context, Protocol
from slipscale.experiments.protocol_parts.building_blocks.comparing import (
    DESIGN,
    Comparing,
    ComparingOptions,
    in_both_orders,
    surface_names,
    the_two_ends,
    with_catch_trials,
)
from slipscale.experiments.protocol_parts.simulated_answers import as_asked
from slipscale.experiments.steps.columns import Column
from slipscale.experiments.steps.questions.comparison import ComparisonQuestion
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.steps import Ask, Steps
from slipscale.experiments.steps.trial import Value
from slipscale.faults import UserError
from slipscale.faults.frozen_table import setting
from slipscale.stimuli.surface import Stimulus

SIZE = {"pairs": 2, "triads": 3}


class PairedComparison(ComparingOptions):
    """Options for paired comparison."""

    form: Literal["pairs", "triads"] = setting(
        "pairs",
        "pairs: which of two surfaces is more slippery. triads: which of the two steps between "
        "three surfaces is larger; the answers give a difference scale.",
    )
    repetitions: AtLeastOne = setting(
        2,
        "Number of presentations per pair or triad; if even, each order is equally frequent.",
        unit="trials per pair or triad",
    )


def compared_surfaces(options: PairedComparison, context: Context) -> tuple[Stimulus, ...]:
    """Return the surfaces to compare: plain surfaces (ascending) and, for pairs, textures."""
    plain = tuple(context.surface(each) for each in sorted(context.levels))
    return plain if options.form == "triads" else (*plain, *context.textures)


def check(options: PairedComparison, context: Context) -> None:
    """Raise `UserError` if there are too few surfaces."""
    size, there = SIZE[options.form], len(compared_surfaces(options, context))
    if there < size:
        raise UserError(
            "form = '{form}' compares {size} surfaces, but the study has {there}",
            form=options.form,
            size=size,
            there=there,
        )


def trials(options: PairedComparison, context: Context) -> int:
    """Return the number of trials in a run, including practice and catch trials."""
    surfaces = compared_surfaces(options, context)
    groups = len(list(combinations(surfaces, SIZE[options.form])))
    return options.practice + options.catch_trials + options.repetitions * groups


def steps(options: PairedComparison, context: Context) -> Steps:
    """Yield the steps of a run."""
    texts = context.texts
    words = answers(texts["comparing.steps" if options.form == "triads" else "comparing.options"])
    question = ComparisonQuestion(
        prompt=texts[f"paired_comparison.{options.form}.question"], options=tuple(words[:2])
    )
    groups = list(combinations(compared_surfaces(options, context), SIZE[options.form]))
    easy = _easy(options, context)
    run = Comparing(
        options,
        context,
        texts=f"paired_comparison.{options.form}",
        question=question,
        practice=the_two_ends(easy, context, "practice", options.practice),
        main=with_catch_trials(
            in_both_orders(groups, options.repetitions, context),
            the_two_ends(easy, context, "main", options.catch_trials),
            context.stream(context.task, "catch"),
        ),
    )
    yield from run.steps()


def _easy(options: PairedComparison, context: Context) -> tuple[Stimulus, ...]:
    """Return a trivially easy pair or triad, made of the surfaces at both ends of the range."""
    surfaces = compared_surfaces(options, context)
    plain = [each for each in surfaces if not each.name] or list(surfaces)
    low, high = plain[0], plain[-1]
    return (low, low, high) if options.form == "triads" else (low, high)


def _answer(step: Ask, person: SimulatedPerson) -> Value:
    """Choose the surface that seemed more slippery, or the step that seemed larger."""
    seemed = person.impressions
    if len(seemed) == SIZE["pairs"]:
        return as_asked(step, person)
    first, second, third = seemed
    return float(1 + person.pick([abs(second - first), abs(third - second)]))


def _intervals(options: PairedComparison) -> int:
    return SIZE[options.form]


PROTOCOL = Protocol(
    task="pairedcomparison",
    title="Paired comparison of {q.judged}",
    description=(
        "The participant chooses the more {q.adjective} surface of each pair, or the larger of "
        "the two steps between three surfaces."
    ),
    options=PairedComparison,
    trials=trials,
    steps=steps,
    answer="response",
    instructions="paired_comparison.pairs.instructions",
    simulated={"response": _answer},
    design=DESIGN,
    stimulus=surface_names("stimulus1", "stimulus2", "stimulus3"),
    response={
        "response": Column(
            description="Interval with the more {q.adjective} surface; with three surfaces, the "
            "larger step (1: from the first to the second surface; 2: from the second to the "
            "third surface)"
        ),
    },
    intervals=_intervals,
    textures=True,
    check=check,
)
