"""Magnitude estimation of slipperiness (Biet 2007, Section IV-B, second experiment).

The surfaces, including textures, are presented in random order. After exploring each surface, the
participant types a number for its slipperiness.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Literal

from pydantic import ValidationInfo, field_validator

from slipscale.experiments.protocol_parts.base import Amplitude, Context, Positive, Protocol
from slipscale.experiments.protocol_parts.building_blocks.rated_surfaces import (
    BLOCK,
    TEXTURE,
    Presentation,
    RatedOptions,
    RatedSurfaces,
    surface_blocks,
    surface_trials,
)
from slipscale.experiments.protocol_parts.simulated_answers import as_asked
from slipscale.experiments.steps.columns import Column, TrialRecord
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.replies import Answer
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.steps import Ask, Explore, Instruct, Present, Silence, Step, Steps
from slipscale.experiments.steps.trial import Value
from slipscale.faults.frozen_table import setting
from slipscale.faults.message import Message

TASK = "magnitudeestimation"


class MagnitudeEstimation(RatedOptions):
    """Options for magnitude estimation, in addition to order and pacing.

    When the maximum exploration time is over, the surface is switched off.
    """

    scale_top: Literal["none", "declared"] = setting(
        "none",
        "declared: the participant first states the number for the most slippery surface "
        "imaginable.",
    )
    standard_level: Amplitude | None = setting(
        None,
        "Amplitude of a standard that is presented before each block; default: no standard and a "
        "free modulus. Requires modulus.",
    )
    modulus: Positive | None = setting(
        None,
        "Number assigned to the standard. Requires the standard.",
        unit="the participant's scale",
        validate_default=True,
    )

    @field_validator("modulus")
    @classmethod
    def _with_its_standard(cls, value: float | None, info: ValidationInfo) -> float | None:
        if "standard_level" in info.data and (value is None) != (
            info.data["standard_level"] is None
        ):
            key = info.context.in_file(("standard_level",))[0] if info.context else "the standard"
            raise ValueError(
                Message("{key} and modulus belong together: set both, or neither", key=key)
            )
        return value


def steps(options: MagnitudeEstimation, context: Context) -> Steps:
    """Yield the steps of a run."""
    texts = context.texts
    form = "instructions" if options.modulus is None else "instructions_standard"
    modulus = options.modulus or 0.0
    yield Instruct(
        title=texts["magnitude_estimation.title"],
        text=texts[f"magnitude_estimation.{form}"].format(
            modulus=f"{modulus:g}", twice=f"{2 * modulus:g}"
        ),
    )
    if options.scale_top == "declared":
        question = NumberQuestion(prompt=texts["magnitude_estimation.scale_top"], positive=True)
        yield Ask(name="scale_top", question=question, task=context.task)
    yield from _Run(options, context).steps(
        practice=texts["magnitude_estimation.practice"], main=texts["magnitude_estimation.main"]
    )


class _Run(RatedSurfaces):
    def __init__(self, options: MagnitudeEstimation, context: Context) -> None:
        super().__init__(options, context, surface_blocks(context.surfaces, options, context))
        self.options = options

    def start(self) -> Steps:
        """Present the standard (if any) before a group of trials."""
        if self.options.standard_level is not None:
            yield from self.standard(self.options.standard_level)

    def standard(self, level: float) -> Steps:
        """Present the standard together with its number."""
        text = self.context.texts["magnitude_estimation.standard"]
        yield Present(surface=self.context.surface(level))
        yield Explore(text=text.format(modulus=f"{self.options.modulus:g}"))
        yield Silence()

    def trial(
        self, condition: Presentation, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield a trial's steps, and return the numbers of the trials to repeat."""
        texts = self.context.texts
        return (
            yield from self.rated(
                condition,
                self.numbered(
                    condition, number, repeats, factors={"modulus": self.options.modulus}
                ),
                explore=texts["magnitude_estimation.explore"],
                name="estimate",
                question=NumberQuestion(prompt=texts["magnitude_estimation.estimate"]),
            )
        )


def _scale_top(_: object, person: SimulatedPerson) -> float:
    return person.scale_top


def _scale_top_of_run(record: TrialRecord) -> Value:
    return record.run_answers.get("scale_top")


PROTOCOL = Protocol(
    task=TASK,
    title="Magnitude estimation of {q.judged}",
    description=(
        "The participant strokes a vibrating plate and types a number for how {q.adjective} "
        "it feels, on their own scale."
    ),
    options=MagnitudeEstimation,
    trials=surface_trials,
    steps=steps,
    answer="estimate",
    instructions="magnitude_estimation.instructions",
    amplitudes=("standard_level",),
    textures=True,
    simulated={
        "estimate": as_asked,
        "scale_top": _scale_top,
    },
    design=BLOCK,
    stimulus=TEXTURE,
    response={
        "estimate": Column(
            description="Magnitude estimate of {q.judged} as typed, on the participant's own scale"
        ),
        "scale_top": Column(
            value=_scale_top_of_run,
            description=(
                "Number that the participant would assign to the most {q.adjective} surface "
                "imaginable, asked before the run"
            ),
        ),
        "modulus": Column(description="Number assigned to the standard; n/a with a free modulus"),
    },
)
