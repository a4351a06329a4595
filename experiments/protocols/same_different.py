"""Same–different: the participant judges whether two surfaces are the same.

No attribute is named, so any kind of difference counts. Half of the trials present the same surface
twice, so that the answers yield the sensitivity in the differencing model (Macmillan and Creelman
2005, Detection Theory, chapter 9).
"""

from __future__ import annotations

from itertools import combinations

from slipscale.experiments.protocol_parts.base import AtLeastOne, Context, Protocol
from slipscale.experiments.protocol_parts.building_blocks.comparing import (
    DESIGN,
    PAIR,
    Comparing,
    ComparingOptions,
    Shown,
    enough_surfaces,
    in_both_orders,
    surface_names,
    the_two_ends,
    with_catch_trials,
)
from slipscale.experiments.protocol_parts.simulated_answers import notices_difference
from slipscale.experiments.steps.columns import Column, Given
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.steps import Steps
from slipscale.faults.frozen_table import setting


class SameDifferent(ComparingOptions):
    """Options for same–different trials."""

    repetitions: AtLeastOne = setting(
        10,
        "Number of presentations per pair of different surfaces; the same number of trials "
        "presents one surface of the pair twice. An even number of presentations balances the "
        "orders and the surfaces.",
        unit="trials per pair",
    )


def trials(options: SameDifferent, context: Context) -> int:
    """Return the number of trials in a run, including practice and catch trials."""
    pairs = len(list(combinations(context.surfaces, PAIR)))
    return options.practice + options.catch_trials + 2 * options.repetitions * pairs


def steps(options: SameDifferent, context: Context) -> Steps:
    """Yield the steps of a run."""
    pairs = list(combinations(context.surfaces, PAIR))
    different = in_both_orders(pairs, options.repetitions, context)
    # Orders alternate, so that both surfaces of a pair occur equally often in "same" trials.
    same = [Shown("main", (each.surfaces[0],) * PAIR, each.factors) for each in different]
    ends = (context.surfaces[0], context.surfaces[-1])
    run = Comparing(
        options,
        context,
        texts="same_different",
        question=YesNoQuestion(prompt=context.texts["same_different.question"]),
        practice=the_two_ends(ends, context, "practice", options.practice),
        main=with_catch_trials(
            context.stream(context.task, "same").shuffled([*different, *same]),
            the_two_ends(ends, context, "main", options.catch_trials),
            context.stream(context.task, "catch"),
        ),
    )
    yield from run.steps()


PROTOCOL = Protocol(
    task="samedifferent",
    title="Same–different",
    description=(
        "The participant strokes two surfaces, which are the same or different, and says whether "
        "they were different."
    ),
    options=SameDifferent,
    trials=trials,
    steps=steps,
    answer="response",
    instructions="same_different.instructions",
    simulated={"response": notices_difference},
    design=DESIGN,
    stimulus=surface_names("first", "second"),
    response={
        "response": Column(
            kind="label",
            description="Whether the participant said that the surfaces were different",
            levels={"true": "different", "false": "the same"},
        ),
    },
    intervals=PAIR,
    textures=True,
    check=Given(enough_surfaces, ("same_different", PAIR)),
)
