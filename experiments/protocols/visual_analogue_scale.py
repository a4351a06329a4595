"""Rating of slipperiness on a visual analogue scale: a mark on a line between two words.

The position of the mark (0 to 100) is bounded and has no unit, so ratios of ratings are
meaningless. The mark's initial position and its visibility bias the answers. The study file
therefore sets both properties, and every row of the data contains them.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator

from slipscale.experiments.protocol_parts.base import Context, Count, Protocol, Switch
from slipscale.experiments.protocol_parts.building_blocks.comparing import DESIGN
from slipscale.experiments.protocol_parts.building_blocks.rated_surfaces import (
    BLOCK,
    TEXTURE,
    Presentation,
    RatedOptions,
    RatedSurfaces,
    surface_blocks,
    surface_trials,
    with_catch_trials,
)
from slipscale.experiments.protocol_parts.simulated_answers import as_asked
from slipscale.experiments.steps.columns import Column
from slipscale.experiments.steps.questions.visual_analogue import VisualAnalogueQuestion
from slipscale.experiments.steps.replies import Answer
from slipscale.experiments.steps.steps import Instruct, Step, Steps
from slipscale.faults.frozen_table import setting
from slipscale.faults.message import Message

LENGTH = 100.0
Start = Literal["left", "middle", "right", "random"]
#: The mark's initial position.
PLACES: dict[Start, float] = {"left": 0.0, "middle": LENGTH / 2, "right": LENGTH}


class VisualAnalogueScale(RatedOptions):
    """Options for ratings on a line, in addition to order and pacing."""

    resolution: Annotated[float, Field(strict=True, ge=0.1, le=10, allow_inf_nan=False)] = setting(
        1.0,
        "Distance between adjacent mark positions on the 100-point line; 1 gives 101 positions. "
        "The distance must divide 100 without a remainder.",
        unit="hundredths of the line",
    )
    key_step: Annotated[float, Field(strict=True, gt=0, le=50, allow_inf_nan=False)] = setting(
        1.0,
        "Distance by which an arrow key moves the mark, a multiple of the resolution; the page "
        "keys move the mark five times as far, and Home and End move it to the ends of the line.",
        unit="hundredths of the line",
        validate_default=True,
    )
    cursor_start: Start = setting(
        "random",
        "Position from which keys move the mark; random: a new position in each trial, so that "
        "the effect of the start is distributed over the line and can be estimated.",
    )
    cursor_shown: Switch = setting(
        False,
        "Whether the mark is visible at its start position before the first press or click. If "
        "false, the line is empty until the first press or click.",
    )
    catch_trials: Count = setting(
        0,
        "Number of catch trials on the bare plate, without vibration, to check attention; not "
        "analysed with the other trials.",
        unit="trials",
    )

    @field_validator("resolution", "key_step")
    @classmethod
    def _whole(cls, value: float, info: ValidationInfo) -> float:
        of, whole = (
            (LENGTH, value)
            if info.field_name == "resolution"
            else (value, info.data.get("resolution", value))
        )
        if abs(of / whole - round(of / whole)) > 1e-9:  # noqa: PLR2004 - 0.1 has no exact float
            raise ValueError(
                "expected a number that divides 100 without a remainder, such as 0.5, 1 or 5"
                if info.field_name == "resolution"
                else Message(
                    "expected a multiple of the resolution ({resolution:g})", resolution=whole
                )
            )
        return value


def trials(options: VisualAnalogueScale, context: Context) -> int:
    """Return the number of trials in a run, including practice and catch trials."""
    return surface_trials(options, context) + options.catch_trials


def possible_levels(options: VisualAnalogueScale, context: Context) -> tuple[float, ...]:
    """Return all levels that the task may present, including the plate at rest for catch trials."""
    bare = (0.0,) if options.catch_trials else ()
    return *(surface.level for surface in context.surfaces), *bare


def steps(options: VisualAnalogueScale, context: Context) -> Steps:
    """Yield the steps of a run."""
    texts = context.texts
    yield Instruct(
        title=texts["visual_analogue_scale.title"],
        text=texts["visual_analogue_scale.instructions"].format(
            left=texts["visual_analogue_scale.left"], right=texts["visual_analogue_scale.right"]
        ),
    )
    yield from _Run(options, context).steps(
        practice=texts["magnitude_estimation.practice"], main=texts["magnitude_estimation.main"]
    )


class _Run(RatedSurfaces):
    def __init__(self, options: VisualAnalogueScale, context: Context) -> None:
        catches = [
            Presentation(0, "main", context.surface(0.0)) for _ in range(options.catch_trials)
        ]
        planned = with_catch_trials(
            surface_blocks(context.surfaces, options, context), catches, context
        )
        super().__init__(options, context, planned)
        self.options = options

    def trial(
        self, condition: Presentation, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield a trial's steps, and return the numbers of the trials to repeat."""
        options, texts = self.options, self.context.texts
        question = VisualAnalogueQuestion(
            prompt=texts["visual_analogue_scale.rating"],
            left=texts["visual_analogue_scale.left"],
            right=texts["visual_analogue_scale.right"],
            resolution=options.resolution,
            key_step=options.key_step,
            start=self._start(number),
            start_shown=options.cursor_shown,
        )
        trial = self.numbered(
            condition,
            number,
            repeats,
            factors={
                "resolution": options.resolution,
                "cursor_start": question.start,
                "cursor_shown": options.cursor_shown,
            },
        )
        return (
            yield from self.rated(
                condition,
                trial,
                explore=texts["visual_analogue_scale.explore"],
                name="rating",
                question=question,
            )
        )

    def _start(self, number: int) -> float:
        options = self.options
        if options.cursor_start != "random":
            return PLACES[options.cursor_start]
        # Drawn as an integer, so that the position is the same on every machine.
        stream = self.context.stream(self.context.task, "cursor", number)
        place = stream.below(round(LENGTH / options.resolution) + 1)
        return round(place * options.resolution, 6)


PROTOCOL = Protocol(
    task="visualanalogue",
    title="Rating of {q.judged} on a visual analogue scale",
    description=(
        "The participant strokes a vibrating plate and places a mark on a line between two "
        "words, by mouse, touch or keys, to rate how {q.adjective} it feels."
    ),
    options=VisualAnalogueScale,
    trials=trials,
    steps=steps,
    answer="rating",
    instructions="visual_analogue_scale.instructions",
    textures=True,
    possible_levels=possible_levels,
    simulated={"rating": as_asked},
    design={**BLOCK, **DESIGN},
    stimulus=TEXTURE,
    response={
        "rating": Column(
            description="Position of the mark on the line, from 0 (left end, the least "
            "{q.adjective}) to 100 (right end)"
        ),
        "resolution": Column(description="Distance between adjacent mark positions"),
        "cursor_start": Column(description="Start position of the mark on the line, 0 to 100"),
        "cursor_shown": Column(
            kind="label",
            description=(
                "Whether the mark was visible at cursor_start before the first press or click"
            ),
            levels={"true": "seen", "false": "the line was empty"},
        ),
    },
)
