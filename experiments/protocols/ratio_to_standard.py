"""Ratio judgements: participants compare each surface's slipperiness with a standard's.

Participants answer how many times as slippery as the standard a surface is. The ratios need no
normalisation and are analysed as logarithms. Surfaces are presented in random order, mixed with
catch trials that compare the standard with itself.
"""

from __future__ import annotations

from collections.abc import Generator

from slipscale.experiments.protocol_parts.base import Context, Protocol
from slipscale.experiments.protocol_parts.building_blocks.against_standard import (
    DESIGN_COLUMNS,
    JUDGED,
    STANDARD_COLUMN,
    AgainstStandard,
    StandardOptions,
)
from slipscale.experiments.protocol_parts.building_blocks.rated_surfaces import (
    Presentation,
    surface_blocks,
    with_catch_trials,
)
from slipscale.experiments.steps.columns import Column
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.replies import Answer
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.steps import Ask, Instruct, Present, Silence, Step, Steps
from slipscale.experiments.steps.trial import Trial


class RatioToStandard(StandardOptions):
    """Options for ratio judgements."""


def trials(options: RatioToStandard, context: Context) -> int:
    """Return the number of trials in a run, including practice and catch trials."""
    return len(context.own_or_listed(None)) * options.rounds + options.catch_trials


def steps(options: RatioToStandard, context: Context) -> Steps:
    """Yield the steps of a run."""
    texts = context.texts
    yield Instruct(
        title=texts["ratio_to_standard.title"], text=texts["ratio_to_standard.instructions"]
    )
    yield from _Run(options, context).steps(
        practice=texts["magnitude_estimation.practice"], main=texts["magnitude_estimation.main"]
    )


class _Run(AgainstStandard):
    def __init__(self, options: RatioToStandard, context: Context) -> None:
        # Textures are not presented, because a ratio is judged for a single amplitude.
        surfaces = [context.surface(each) for each in context.own_or_listed(None)]
        catch = Presentation(0, "main", context.surface(options.standard_level))
        planned = with_catch_trials(
            surface_blocks(surfaces, options, context), [catch] * options.catch_trials, context
        )
        super().__init__(options, context, planned, context.texts["ratio_to_standard.standard"])

    def trial(
        self, condition: Presentation, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield a trial's steps, and return the numbers of the trials to repeat."""
        texts = self.context.texts
        trial = self.numbered(
            condition,
            number,
            repeats,
            factors={
                "standard_level": self.against.standard_level,
                "comparison_level": condition.surface.level,
            },
        )
        question = NumberQuestion(prompt=texts["ratio_to_standard.ratio"], positive=True)
        explore = texts["ratio_to_standard.explore"]
        yield from self.standard(trial)
        if not self.against.in_each_trial:
            rated = self.rated(condition, trial, explore=explore, name="ratio", question=question)
            return (yield from rated)
        return (yield from self._compared(condition, trial, explore, question))

    def _compared(
        self, condition: Presentation, trial: Trial, explore: str, question: NumberQuestion
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield the surface that follows the standard, then the question about their ratio."""
        yield Present(surface=condition.surface, trial=trial, interval=JUDGED)
        yield self.order.explore(explore, trial, interval=JUDGED)
        yield Silence(trial=trial, interval=JUDGED)
        reply = yield Ask(
            name="ratio",
            question=question,
            trial=trial,
            time_limit_s=self.order.response_time_limit_s,
        )
        return (yield from self.over(trial, reply))


def _ratio(_: object, person: SimulatedPerson) -> float:
    return person.ratio()


def _intervals(options: RatioToStandard) -> int:
    return JUDGED if options.in_each_trial else 0


PROTOCOL = Protocol(
    task="ratiotostandard",
    title="Ratio judgements of {q.judged} against a standard",
    description=(
        "The participant feels a standard and another surface, and types how many times as "
        "{q.adjective} as the standard the other surface is."
    ),
    options=RatioToStandard,
    trials=trials,
    steps=steps,
    answer="ratio",
    instructions="ratio_to_standard.instructions",
    amplitudes=("standard_level",),
    simulated={"ratio": _ratio},
    design=DESIGN_COLUMNS,
    stimulus={
        **STANDARD_COLUMN,
        "comparison_level": Column(
            description="{q.title} of the surface judged{q.behind}", units="{q.bids}"
        ),
    },
    response={
        "ratio": Column(
            description=(
                "Typed ratio above 0: the surface felt this many times as {q.adjective} as the "
                "standard"
            )
        ),
    },
    intervals=_intervals,
)
