"""Magnitude production: the participant adjusts the plate to match a given number.

In magnitude estimation, by contrast, the surface is given and the participant answers with a
number. People compress the range of the variable that they control (Stevens and Greenbaum 1966,
Perception & Psychophysics 1, 439-446). The exponents of the two methods therefore differ, and the
true exponent lies between them.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Annotated, Literal

from pydantic import Field, field_validator

from slipscale.experiments.protocol_parts.base import AtLeastOne, Context, Count, Positive, Protocol
from slipscale.experiments.protocol_parts.building_blocks.adjusting import adjusted_columns
from slipscale.experiments.protocol_parts.building_blocks.against_standard import (
    DESIGN_COLUMNS,
    JUDGED,
    STANDARD,
    STANDARD_COLUMN,
    AgainstStandard,
    StandardOptions,
)
from slipscale.experiments.protocol_parts.building_blocks.rated_surfaces import (
    Presentation,
    order_blocks,
    with_catch_trials,
)
from slipscale.experiments.protocol_parts.simulated_answers import until_number
from slipscale.experiments.steps.columns import Column, TrialRecord
from slipscale.experiments.steps.replies import Answer
from slipscale.experiments.steps.rounding import rounded
from slipscale.experiments.steps.steps import Adjust, Instruct, Present, Silence, Step, Steps
from slipscale.experiments.steps.trial import Value
from slipscale.faults import UserError
from slipscale.faults.frozen_table import setting
from slipscale.stimuli.surface import Stimulus

Began = Literal["low", "high"]
BEGAN: tuple[Began, ...] = ("low", "high")
#: Fraction of the adjustment range at the lower or upper end, from which the start level is drawn.
START_SHARE = 0.25


class MagnitudeProduction(StandardOptions):
    """Options for magnitude production."""

    numbers: Annotated[tuple[Positive, ...], Field(min_length=2)] = Field(
        description="Numbers shown to the participant, all different; the modulus is the number "
        "of the standard.",
        json_schema_extra={"unit": "the modulus's scale"},
    )
    modulus: Positive = setting(10.0, "Number assigned to the standard.", unit="the numbers' scale")
    practice: Count = setting(
        1,
        "Number of practice trials for each number shown and each starting side (low and high), "
        "before the main trials; recorded but not analysed.",
        unit="trials per number and starting side",
    )
    repetitions: AtLeastOne = setting(
        2,
        "Number of main trials for each number shown and each starting side (low and high).",
        unit="trials per number and starting side",
    )
    step_level: Positive = setting(0.05, "Change per wheel notch or key press.")
    lowest_level: Positive = setting(0.1, "Lower limit of the adjustment.")
    highest_level: Positive = setting(2.3, "Upper limit of the adjustment.")

    @field_validator("numbers")
    @classmethod
    def _different(cls, value: tuple[float, ...]) -> tuple[float, ...]:
        if len(set(value)) < len(value):
            raise ValueError("expected different numbers")
        return value


def check(options: MagnitudeProduction, context: Context) -> None:
    """Raise `UserError` if the standard is outside the adjustment range or a step is too large."""
    low, high, q = options.lowest_level, options.highest_level, context.quantity
    if not low < options.standard_level < high:
        raise UserError(
            "the standard is {standard_level}, but must be between {lowest_key} and {highest_key} "
            "({low:g} to {high:g}), so that participants can set levels below and above the "
            "standard",
            standard_level=q.short(options.standard_level),
            lowest_key=q.named("lowest_level"),
            highest_key=q.named("highest_level"),
            low=low,
            high=high,
        )
    if options.step_level > (high - low) / 2:
        raise UserError(
            "{key} is {step_level:g}; expected at most half of the adjustment range ({high})",
            key=q.named("step_level"),
            step_level=options.step_level,
            high=q.short((high - low) / 2),
        )


def possible_levels(options: MagnitudeProduction, _context: Context) -> tuple[float, ...]:
    """Return the limits of the adjustment range and the level of the standard."""
    return options.lowest_level, options.highest_level, options.standard_level


def trials(options: MagnitudeProduction, _context: Context) -> int:
    """Return the number of trials in a run, including practice and catch trials."""
    return len(options.numbers) * len(BEGAN) * options.rounds + options.catch_trials


def steps(options: MagnitudeProduction, context: Context) -> Steps:
    """Yield the steps of a run."""
    texts = context.texts
    modulus = options.modulus
    yield Instruct(
        title=texts["magnitude_production.title"],
        text=texts["magnitude_production.instructions"].format(
            modulus=f"{modulus:g}", twice=f"{2 * modulus:g}"
        ),
    )
    yield from _Run(options, context).steps(
        practice=texts["magnitude_estimation.practice"], main=texts["magnitude_estimation.main"]
    )


class _Run(AgainstStandard):
    def __init__(self, options: MagnitudeProduction, context: Context) -> None:
        self.options = options
        self._starts = context.stream(context.task, "starts")
        words = context.texts["magnitude_estimation.standard"]
        super().__init__(
            options,
            context,
            self._plan(options, context),
            words.format(modulus=f"{options.modulus:g}"),
        )

    def _plan(self, options: MagnitudeProduction, context: Context) -> list[list[Presentation]]:
        conditions = [(number, began) for number in options.numbers for began in BEGAN]
        planned = [
            [
                Presentation(block, phase, *self._production(context, *conditions[each]))
                for each in order
            ]
            for block, (phase, order) in enumerate(
                order_blocks(len(conditions), options, context), start=1
            )
        ]
        catches = [
            Presentation(
                0, "main", *self._production(context, options.modulus, BEGAN[turn % len(BEGAN)])
            )
            for turn in range(options.catch_trials)
        ]
        return with_catch_trials(planned, catches, context)

    def _production(
        self, context: Context, number: float, began: Began
    ) -> tuple[Stimulus, dict[str, Value]]:
        """Return a trial's initial surface and the values of its columns."""
        low, high = self.options.lowest_level, self.options.highest_level
        away = START_SHARE * (high - low) * self._starts.uniform()
        start = rounded(low + away if began == "low" else high - away)
        return context.surface(start), {"number": number, "began": began}

    def trial(
        self, condition: Presentation, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield a trial's steps, and return the numbers of the trials to repeat."""
        options = self.options
        trial = self.numbered(
            condition,
            number,
            repeats,
            factors={
                "modulus": options.modulus,
                "standard_level": options.standard_level,
                "lowest_level": options.lowest_level,
                "highest_level": options.highest_level,
                "step_level": options.step_level,
            },
        )
        yield from self.standard(trial)
        interval = JUDGED if options.in_each_trial else STANDARD
        yield Present(surface=condition.surface, trial=trial, interval=interval)
        shown = f"{condition.factors['number']:g}"
        reply = yield Adjust(
            name="produced_level",
            text=self.context.texts["magnitude_production.turn"].format(number=shown),
            trial=trial,
            interval=interval,
            step_level=options.step_level,
            lowest_level=options.lowest_level,
            highest_level=options.highest_level,
            time_limit_s=options.response_time_limit_s,
        )
        yield Silence(trial=trial, interval=interval)
        return (yield from self.over(trial, reply))


def _bound(record: TrialRecord) -> str | None:
    answer, factors = record.answer("produced_level"), record.trial.factors
    if answer is None:
        return None
    known = (answer, *(factors[f"{name}_level"] for name in ("lowest", "highest", "step")))
    reached, low, high, step = (float(str(value)) for value in known)
    return "lowest" if reached < low + step else "highest" if reached > high - step else "none"


def _intervals(options: MagnitudeProduction) -> int:
    return JUDGED if options.in_each_trial else STANDARD


PROTOCOL = Protocol(
    task="magnitudeproduction",
    title="Magnitude production of {q.judged}",
    description=(
        "The participant feels a standard with a given number, is shown another number, and "
        "adjusts the plate until it feels as {q.adjective} as that number indicates."
    ),
    options=MagnitudeProduction,
    trials=trials,
    steps=steps,
    answer="produced_level",
    instructions="magnitude_production.instructions",
    amplitudes=("standard_level", "step_level", "lowest_level", "highest_level"),
    possible_levels=possible_levels,
    check=check,
    simulated={"produced_level": until_number},
    design={
        **DESIGN_COLUMNS,
        "number": Column(description="Number shown to the participant"),
        "modulus": Column(description="Number assigned to the standard"),
        "began": Column(
            kind="label",
            description="Starting point of the plate",
            levels={
                "low": "in the lowest quarter of the adjustment range",
                "high": "in the highest quarter",
            },
        ),
    },
    stimulus=STANDARD_COLUMN,
    response={
        **adjusted_columns("produced_level", "{q.title} set by the participant"),
        "bound": Column(
            value=_bound,
            kind="label",
            description=(
                "Whether the final setting was within one notch of a limit of the adjustment range"
            ),
            levels={
                "lowest": "of the lower limit",
                "highest": "of the upper limit",
                "none": "of neither",
            },
        ),
    },
    intervals=_intervals,
)
