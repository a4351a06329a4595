"""Free sorting: the participant sorts the surfaces into groups that feel alike.

Surfaces are presented one by one, in several rounds with new orders. If a participant assigns a
surface to several groups, the last group is used. The dissimilarity of two surfaces is the
proportion of participants who put the surfaces in different groups, as in Hollins and others (1993,
Perception & Psychophysics 54, 697-705) for textures.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Annotated

from pydantic import Field

from slipscale.experiments.protocol_parts.base import AtLeastOne, Context, Count, Protocol
from slipscale.experiments.protocol_parts.building_blocks.comparing import (
    enough_surfaces,
    surface_name,
)
from slipscale.experiments.protocol_parts.building_blocks.rated_surfaces import (
    BLOCK,
    TEXTURE,
    Presentation,
    RatedOptions,
    RatedSurfaces,
    surface_blocks,
    surface_trials,
)
from slipscale.experiments.steps.columns import Column, Given
from slipscale.experiments.steps.questions.whole_number import WholeNumberQuestion
from slipscale.experiments.steps.replies import Answer
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.steps import Ask, Instruct, Step, Steps
from slipscale.faults.frozen_table import setting

FEWEST = 3


class Sorting(RatedOptions):
    """Options for free sorting, in addition to order and pacing."""

    repetitions: AtLeastOne = setting(
        2,
        "Number of rounds; every surface is sorted once per round, and the last round counts.",
        unit="rounds",
    )
    practice: Count = setting(0, "Number of practice rounds.", unit="rounds")
    groups: Annotated[int, Field(strict=True, ge=2, le=20)] = setting(
        5, "Largest number of groups; the participant may use fewer.", unit="groups"
    )


def steps(options: Sorting, context: Context) -> Steps:
    """Yield the steps of a run."""
    texts = context.texts
    yield Instruct(
        title=texts["sorting.title"],
        text=texts["sorting.instructions"].format(groups=options.groups),
    )
    yield from _Run(options, context).steps(
        practice=texts["magnitude_estimation.practice"], main=texts["magnitude_estimation.main"]
    )


class _Run(RatedSurfaces):
    def __init__(self, options: Sorting, context: Context) -> None:
        super().__init__(options, context, surface_blocks(context.surfaces, options, context))
        self.options = options

    def trial(
        self, condition: Presentation, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield a trial's steps; return the trials to repeat."""
        texts = self.context.texts
        return (
            yield from self.rated(
                condition,
                self.numbered(condition, number, repeats, factors={}),
                explore=texts["magnitude_estimation.explore"],
                name="group",
                question=WholeNumberQuestion(
                    prompt=texts["sorting.question"], minimum=1, maximum=self.options.groups
                ),
            )
        )


def _answer(step: Ask, person: SimulatedPerson) -> float:
    """Choose the group that corresponds to the strength of the impression."""
    question = step.of_kind(WholeNumberQuestion)
    if person.lapses():
        return float(1 + person.stream("lapse", "value").below(question.maximum))
    share = min(max(person.impressions[0] / 100, 0.0), 1.0)
    return float(min(1 + int(share * question.maximum), question.maximum))


PROTOCOL = Protocol(
    task="sorting",
    title="Free sorting",
    description=(
        "The participant strokes one surface per trial and types the number of the group to "
        "which the surface belongs; surfaces that feel alike share a group."
    ),
    options=Sorting,
    trials=surface_trials,
    steps=steps,
    answer="group",
    instructions="sorting.instructions",
    simulated={"group": _answer},
    design=BLOCK,
    stimulus={
        "texture": TEXTURE["texture"],
        "item": Column(
            value=surface_name,
            kind="label",
            description=(
                "Surface, given as its {q.name} in {q.unit_in_full} or as the texture's name"
            ),
        ),
    },
    response={
        "group": Column(
            description=(
                "Number of the group that the participant chose; group numbers have no order"
            ),
        ),
    },
    textures=True,
    check=Given(enough_surfaces, ("sorting", FEWEST)),
)
