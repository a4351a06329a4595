"""Similarity rating: the participant rates how different the surfaces of each pair are.

The rating is a mark on a line from identical to completely different. Multidimensional scaling of
the ratings yields a map of the surfaces, as in Hollins and others (1993, Perception & Psychophysics
54, 697-705) for textures. No attribute is named, so participants decide what counts as a
difference.
"""

from __future__ import annotations

from itertools import combinations

from slipscale.experiments.protocol_parts.base import AtLeastOne, Context, Protocol, Switch
from slipscale.experiments.protocol_parts.building_blocks.comparing import (
    DESIGN,
    PAIR,
    Comparing,
    ComparingOptions,
    enough_surfaces,
    in_both_orders,
    surface_names,
    the_two_ends,
    with_catch_trials,
)
from slipscale.experiments.steps.columns import Column, Given
from slipscale.experiments.steps.questions.visual_analogue import VisualAnalogueQuestion
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.steps import Ask, Steps
from slipscale.faults.frozen_table import setting
from slipscale.stimuli.surface import Stimulus

FEWEST = 3
RESOLUTION = 1.0


class Similarity(ComparingOptions):
    """Options for similarity rating."""

    repetitions: AtLeastOne = setting(
        2,
        "Number of ratings per pair; if even, both orders are equally frequent.",
        unit="trials per pair",
    )
    identical_pairs: Switch = setting(False, "Whether each surface is also paired with itself.")


def pairs(options: Similarity, context: Context) -> list[tuple[Stimulus, ...]]:
    """Return all pairs of the study's surfaces, including textures."""
    surfaces = context.surfaces
    same = [(each, each) for each in surfaces] if options.identical_pairs else []
    return [*combinations(surfaces, PAIR), *same]


def trials(options: Similarity, context: Context) -> int:
    """Return the number of trials in a run, including practice and catch trials."""
    main = options.repetitions * len(pairs(options, context))
    return options.practice + options.catch_trials + main


def steps(options: Similarity, context: Context) -> Steps:
    """Yield the steps of a run."""
    texts = context.texts
    question = VisualAnalogueQuestion(
        prompt=texts["similarity.question"],
        left=texts["similarity.left"],
        right=texts["similarity.right"],
        resolution=RESOLUTION,
        key_step=RESOLUTION,
        start=0.0,
        start_shown=False,
    )
    ends = (context.surfaces[0], context.surfaces[-1])
    run = Comparing(
        options,
        context,
        texts="similarity",
        name="dissimilarity",
        question=question,
        practice=the_two_ends(ends, context, "practice", options.practice),
        main=with_catch_trials(
            in_both_orders(pairs(options, context), options.repetitions, context),
            the_two_ends(ends, context, "main", options.catch_trials),
            context.stream(context.task, "catch"),
        ),
    )
    yield from run.steps()


def _answer(step: Ask, person: SimulatedPerson) -> float:
    question = step.of_kind(VisualAnalogueQuestion)
    if person.lapses():
        return question.nearest(100 * person.stream("lapse", "value").uniform())
    first, second = person.impressions
    return question.nearest(abs(first - second))


PROTOCOL = Protocol(
    task="similarity",
    title="Similarity rating",
    description=(
        "The participant strokes two surfaces and marks on a line how different they are, from "
        "identical to completely different."
    ),
    options=Similarity,
    trials=trials,
    steps=steps,
    answer="dissimilarity",
    instructions="similarity.instructions",
    simulated={"dissimilarity": _answer},
    design=DESIGN,
    stimulus=surface_names("first", "second"),
    response={
        "dissimilarity": Column(
            description=(
                "Position of the mark on the line, from 0 (identical) to 100 (completely different)"
            )
        ),
    },
    intervals=PAIR,
    textures=True,
    check=Given(enough_surfaces, ("similarity", FEWEST)),
)
