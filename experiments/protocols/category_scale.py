"""Category scale: each surface is rated in one of a few ordered, labelled categories."""

from __future__ import annotations

from collections.abc import Generator
from typing import Annotated

from pydantic import Field

from slipscale.experiments.languages.texts import FEWEST_ANSWERS, NUMBER_KEYS
from slipscale.experiments.protocol_parts.base import AtLeastOne, Context, Protocol, Words
from slipscale.experiments.protocol_parts.building_blocks.rated_surfaces import (
    BLOCK,
    TEXTURE,
    Presentation,
    RatedOptions,
    RatedSurfaces,
    surface_blocks,
    surface_trials,
)
from slipscale.experiments.steps.columns import Column, TrialRecord
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.replies import Answer
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.steps import Ask, Instruct, Step, Steps
from slipscale.faults.frozen_table import setting


class CategoryScale(RatedOptions):
    """Options for category ratings, in addition to order and pacing."""

    repetitions: AtLeastOne = setting(
        3, "Number of ratings per surface.", unit="ratings per surface"
    )
    labels: Annotated[
        tuple[Words, ...], Field(min_length=FEWEST_ANSWERS, max_length=NUMBER_KEYS)
    ] = Field(
        description="Category labels shown on the screen, from the lowest to the highest, in the "
        "study's language."
    )


def steps(options: CategoryScale, context: Context) -> Steps:
    """Yield the steps of a run."""
    texts = context.texts
    yield Instruct(title=texts["category_scale.title"], text=texts["category_scale.instructions"])
    yield from _Run(options, context).steps(
        practice=texts["magnitude_estimation.practice"], main=texts["magnitude_estimation.main"]
    )


class _Run(RatedSurfaces):
    def __init__(self, options: CategoryScale, context: Context) -> None:
        super().__init__(options, context, surface_blocks(context.surfaces, options, context))
        self.labels = options.labels

    def trial(
        self, condition: Presentation, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield a trial's steps, and return the numbers of the trials to repeat."""
        texts, factors = self.context.texts, {"categories": len(self.labels)}
        coded = tuple((str(place), label) for place, label in enumerate(self.labels, start=1))
        return (
            yield from self.rated(
                condition,
                self.numbered(condition, number, repeats, factors=factors),
                explore=texts["magnitude_estimation.explore"],
                name="rating",
                question=ChoiceQuestion(prompt=texts["category_scale.question"], options=coded),
            )
        )


def _rating(record: TrialRecord) -> float | None:
    answer = record.answer("rating")
    return None if answer is None else float(answer)


def _answer(step: Ask, person: SimulatedPerson) -> str:
    """Choose the category that corresponds to the person's mark on a line."""
    options = step.of_kind(ChoiceQuestion).options
    place = int(person.rating(0.0) / 100 * len(options))
    return options[min(place, len(options) - 1)][0]


PROTOCOL = Protocol(
    task="categoryscale",
    title="Category scale of {q.judged}",
    description=(
        "The participant strokes a surface and chooses one of a few ordered categories for how "
        "{q.adjective} it feels."
    ),
    options=CategoryScale,
    trials=surface_trials,
    steps=steps,
    answer="rating",
    instructions="category_scale.instructions",
    simulated={"rating": _answer},
    design=BLOCK,
    stimulus=TEXTURE,
    response={
        "rating": Column(
            value=_rating,
            description="Number of the chosen category: 1 is the lowest (the least {q.adjective})",
        ),
        "categories": Column(description="Number of categories"),
    },
    textures=True,
)
