"""Identification: the participant learns a number for each surface, then identifies surfaces.

The confusion matrix yields the information transferred (Miller 1956, Psychological Review 63,
81-97).
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Literal

from slipscale.experiments.languages.texts import NUMBER_KEYS
from slipscale.experiments.protocol_parts.base import AtLeastOne, Context, Count, Positive, Protocol
from slipscale.experiments.protocol_parts.building_blocks.comparing import surface_name
from slipscale.experiments.protocol_parts.building_blocks.rated_surfaces import (
    BLOCK,
    Presentation,
    RatedOptions,
    RatedSurfaces,
    surface_blocks,
)
from slipscale.experiments.steps.columns import Column
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.replies import Answer, Reply
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.steps import Ask, Feedback, Instruct, Present, Silence, Step, Steps
from slipscale.faults import UserError
from slipscale.faults.frozen_table import setting

FEWEST = 2


class Identification(RatedOptions):
    """Options for identification, in addition to order and pacing."""

    repetitions: AtLeastOne = setting(
        10, "Number of presentations per surface.", unit="trials per surface"
    )
    learning: Count = setting(
        2,
        "Number of times each surface is presented with its number before the trials.",
        unit="presentations per surface",
    )
    feedback: Literal["none", "practice", "always"] = setting(
        "practice", "Trials in which the participant is shown the correct number."
    )
    feedback_s: Positive = setting(1.5, "Duration of the feedback.")


def check(_options: Identification, context: Context) -> None:
    """Raise `UserError` unless each surface can have its own number key."""
    if not FEWEST <= (levels := len(context.levels)) <= NUMBER_KEYS:
        q = context.quantity
        raise UserError(
            "identification: {key} has {levels}, expected {fewest} to {number_keys}",
            key=q.named("levels"),
            levels=levels,
            fewest=FEWEST,
            number_keys=NUMBER_KEYS,
        )


def trials(options: Identification, context: Context) -> int:
    """Return the number of trials in a run, including practice."""
    return len(context.levels) * options.rounds


def steps(options: Identification, context: Context) -> Steps:
    """Yield the steps of a run."""
    texts = context.texts
    surfaces = [context.surface(level) for level in context.levels]
    yield Instruct(
        title=texts["identification.title"],
        text=texts["identification.instructions"].format(count=len(surfaces)),
    )
    for _ in range(options.learning):
        for number, surface in enumerate(surfaces, start=1):
            yield Present(surface=surface)
            yield options.explore(texts["identification.learn"].format(number=number))
            yield Silence()
    yield from _Run(options, context).steps(
        practice=texts["magnitude_estimation.practice"], main=texts["magnitude_estimation.main"]
    )


class _Run(RatedSurfaces):
    def __init__(self, options: Identification, context: Context) -> None:
        surfaces = [context.surface(level) for level in context.levels]
        super().__init__(options, context, surface_blocks(surfaces, options, context))
        self.options = options

    def trial(
        self, condition: Presentation, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield a trial's steps, and return the numbers of the trials to repeat."""
        options, texts, levels = self.options, self.context.texts, self.context.levels
        trial = self.numbered(condition, number, repeats, factors={})
        # The code is the surface's name in the data; the participant sees the surface's number.
        coded = tuple((f"{level:g}", str(place)) for place, level in enumerate(levels, start=1))
        reply = yield from self.asked(
            condition,
            trial,
            explore=texts["magnitude_estimation.explore"],
            name="named",
            question=ChoiceQuestion(prompt=texts["identification.question"], options=coded),
        )
        answered = isinstance(reply, Reply) and reply.value is not None
        if answered and options.feedback in ("always", condition.phase):
            right = 1 + levels.index(condition.surface.level)
            text = texts["identification.feedback"].format(number=right)
            yield Feedback(text=text, duration_s=options.feedback_s, trial=trial)
        return (yield from self.over(trial, reply))


def _answer(step: Ask, person: SimulatedPerson) -> str:
    """Choose the surface whose usual sensation is closest to the sensation in this trial."""
    question = step.of_kind(ChoiceQuestion)
    (seemed,) = person.impressions
    away = [-abs(seemed - person.usual(float(code))) for code, _ in question.options]
    return question.options[person.pick(away)][0]


PROTOCOL = Protocol(
    task="identification",
    title="Identification",
    description=(
        "The participant learns a number for each surface, then strokes one surface per trial "
        "and names its number."
    ),
    options=Identification,
    trials=trials,
    steps=steps,
    answer="named",
    instructions="identification.instructions",
    simulated={"named": _answer},
    design=BLOCK,
    stimulus={
        "presented": Column(
            value=surface_name,
            kind="label",
            description="The presented surface, given as its {q.name} in {q.unit_in_full}",
        ),
    },
    response={
        "named": Column(
            kind="label",
            description=(
                "The surface that the participant named, given as its {q.name} in {q.unit_in_full}"
            ),
        ),
    },
    check=check,
)
