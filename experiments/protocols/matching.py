"""Matching: the participant adjusts the plate until it feels like the preceding reference.

The plate starts above and below the reference equally often. The difference between settings from
above and from below is the participant's hysteresis; the mean of the settings is the point of
subjective equality. A catch trial starts at the reference itself.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import Annotated, Literal, NamedTuple

from pydantic import Field

from slipscale.experiments.protocol_parts.base import (
    Amplitude,
    AtLeastOne,
    Context,
    Count,
    Positive,
    Protocol,
    Switch,
)
from slipscale.experiments.protocol_parts.building_blocks.adjusting import adjusted_columns
from slipscale.experiments.protocol_parts.building_blocks.comparing import (
    IntervalTask,
    with_catch_trials,
)
from slipscale.experiments.protocol_parts.building_blocks.pacing import RestedOptions
from slipscale.experiments.protocol_parts.building_blocks.repeating import part_over
from slipscale.experiments.protocol_parts.simulated_answers import until_equal
from slipscale.experiments.steps.columns import Column, TrialRecord, truth
from slipscale.experiments.steps.replies import Answer, Reply, Voided
from slipscale.experiments.steps.rounding import rounded
from slipscale.experiments.steps.steps import (
    Adjust,
    EndTrial,
    Instruct,
    Present,
    Silence,
    Step,
    Steps,
)
from slipscale.experiments.steps.trial import Phase, Trial
from slipscale.faults import UserError
from slipscale.faults.frozen_table import setting

REFERENCE, TURNED = 1, 2
Direction = Literal["ascending", "descending", "equal"]
DIRECTIONS: tuple[Direction, ...] = ("ascending", "descending")
EQUAL: Direction = "equal"  # starts at the reference: a catch trial


class Matching(RestedOptions):
    """Options for matching."""

    reference_levels: Annotated[tuple[Amplitude, ...], Field(min_length=1)] | None = setting(
        None, "Amplitudes to be matched; default: the study's amplitudes."
    )
    repetitions: AtLeastOne = setting(
        3,
        "Number of matches per reference in each direction, from below and from above.",
        unit="trials per reference and direction",
    )
    practice: Count = setting(
        2,
        "Number of practice trials before the main trials; recorded but not analysed.",
        unit="trials",
    )
    step_level: Positive = setting(0.02, "Change per wheel notch or key press.")
    nearest_start_level: Positive = setting(
        0.3, "Smallest difference between the start level of a trial and the reference."
    )
    furthest_start_level: Positive = setting(
        0.6, "Largest difference between the start level of a trial and the reference."
    )
    lowest_level: Amplitude = setting(0.0, "Lower limit of the adjustment.")
    highest_level: Positive = setting(2.3, "Upper limit of the adjustment.")
    catch_trials: Count = setting(
        0,
        "Number of catch trials, which start at the reference itself: a match far from the "
        "reference indicates a lapse of attention or memory. Catch trials are excluded from the "
        "analysis of matches.",
        unit="trials",
    )
    reference_again: Switch = setting(
        False,
        "Whether a key presents the reference again during the adjustment, as often as the "
        "participant wants; the number of times is recorded.",
    )
    repeat_timed_out: Switch = setting(True, "Whether a timed-out trial is repeated once.")

    def references(self, context: Context) -> tuple[float, ...]:
        """Return the amplitudes to be matched, µm peak to peak."""
        return context.own_or_listed(self.reference_levels)


def check(options: Matching, context: Context) -> None:
    """Raise `UserError` if starting points are contradictory or outside the adjustment range."""
    q = context.quantity
    if options.furthest_start_level < options.nearest_start_level:
        raise UserError(
            "{furthest_key} is {furthest_start_level:g}, expected at least {nearest_key} "
            "({nearest_start_level:g})",
            furthest_key=q.named("furthest_start_level"),
            furthest_start_level=options.furthest_start_level,
            nearest_key=q.named("nearest_start_level"),
            nearest_start_level=options.nearest_start_level,
        )
    for reference in options.references(context):
        low, high = (
            reference - options.furthest_start_level,
            reference + options.furthest_start_level,
        )
        if low < options.lowest_level or high > options.highest_level:
            raise UserError(
                "trials for the reference {reference} start at {low:g} to {high}, outside the "
                "adjustment range ({lowest_level:g} to {highest_level:g}); choose a reference "
                "further from its limits",
                reference=q.short(reference),
                low=low,
                high=q.short(high),
                lowest_level=options.lowest_level,
                highest_level=options.highest_level,
            )


def possible_levels(options: Matching, context: Context) -> tuple[float, ...]:
    """Return the limits of the adjustment range and the references."""
    return options.lowest_level, options.highest_level, *options.references(context)


def trials(options: Matching, context: Context) -> int:
    """Return the number of trials in a run, including practice and catch trials."""
    main = len(DIRECTIONS) * options.repetitions * len(options.references(context))
    return options.practice + options.catch_trials + main


class _Match(NamedTuple):
    """The definition of a trial: its direction, and its reference and start in µm peak to peak."""

    phase: Phase
    reference: float
    direction: Direction
    start: float


def steps(options: Matching, context: Context) -> Steps:
    """Yield the steps of a run."""
    texts = context.texts
    instructions = texts["matching.instructions"]
    if options.reference_again:
        instructions = f"{instructions.rstrip()}\n\n{texts['matching.feel_again']}"
    yield Instruct(title=texts["matching.title"], text=instructions)
    run = _Run(options, context)
    stream = context.stream(context.task, "main")
    conditions = [(r, d) for r in options.references(context) for d in DIRECTIONS]
    if options.practice:
        yield Instruct(text=texts["comparing.practice"])
        practice = [stream.choice(conditions) for _ in range(options.practice)]
        yield from run.block([run.match("practice", *each) for each in practice])
        yield from run.close(lambda: Instruct(text=texts["comparing.main"]))
    main = [each for _ in range(options.repetitions) for each in stream.shuffled(conditions)]
    yield from run.block(run.among_catch_trials([run.match("main", *each) for each in main]))
    yield from run.close(lambda: part_over(texts))


class _Run(IntervalTask[_Match]):
    def __init__(self, options: Matching, context: Context) -> None:
        super().__init__(trials(options, context), options, context)
        self.options = options
        self._starts = context.stream(context.task, "starts")

    def match(self, phase: Phase, reference: float, direction: Direction) -> _Match:
        """Return a trial's definition; its starting point is random, except in a catch trial."""
        options = self.options
        span = options.furthest_start_level - options.nearest_start_level
        if direction == EQUAL:
            return _Match(phase, reference, direction, reference)
        away = options.nearest_start_level + span * self._starts.uniform()
        start = rounded(reference - away if direction == "ascending" else reference + away)
        return _Match(phase, reference, direction, start)

    def among_catch_trials(self, planned: Sequence[_Match]) -> list[_Match]:
        """Insert catch trials at random positions; all placements are equally likely."""
        options, context = self.options, self.context
        stream = context.stream(context.task, "catch")
        references = options.references(context)
        catches = [
            self.match("main", stream.choice(references), EQUAL)
            for _ in range(options.catch_trials)
        ]
        return with_catch_trials(planned, catches, stream)

    def trial(
        self, condition: _Match, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield a trial's steps, and return the numbers of the trials to repeat."""
        options, context = self.options, self.context
        trial = Trial(
            task=context.task,
            number=number,
            total=self.total,
            phase=condition.phase,
            factors={"direction": condition.direction},
            repeats=repeats,
        )
        reference = context.surface(condition.reference)
        yield from self.interval(reference, trial, REFERENCE)
        start = context.surface(condition.start)
        yield Present(surface=start, trial=trial, interval=TURNED)
        reply = yield Adjust(
            name="matched_level",
            text=context.texts["matching.turn"],
            trial=trial,
            interval=TURNED,
            step_level=options.step_level,
            lowest_level=options.lowest_level,
            highest_level=options.highest_level,
            time_limit_s=options.response_time_limit_s,
            again=(
                Present(surface=reference, trial=trial, interval=REFERENCE),
                self.exploration(trial, REFERENCE),
            )
            if options.reference_again
            else None,
        )
        yield Silence(trial=trial, interval=TURNED)
        voided = yield EndTrial(trial=trial)
        again = voided.trials if isinstance(voided, Voided) else ()
        missed = isinstance(reply, Reply) and reply.timed_out and number not in again
        if missed and options.repeat_timed_out and repeats is None:
            again = (*again, number)
        return again


def _catch(record: TrialRecord) -> str | None:
    return truth(record.trial.factors["direction"] == EQUAL)


def _felt_again(record: TrialRecord) -> float | None:
    found = record.answers.get("matched_level")
    return None if found is None else float(len(found["again_s"]))


def _finest_level(options: Matching, context: Context) -> tuple[float, float]:
    return options.nearest_start_level, max(options.references(context))


PROTOCOL = Protocol(
    task="matching",
    title="Matching by adjustment",
    description=(
        "The participant feels a reference, then adjusts the plate from below or above until "
        "both feel the same."
    ),
    options=Matching,
    trials=trials,
    steps=steps,
    answer="matched_level",
    instructions="matching.instructions",
    simulated={"matched_level": until_equal},
    design={
        "direction": Column(
            kind="label",
            description="Side from which the reference was approached",
            levels={
                "ascending": "from below",
                "descending": "from above",
                EQUAL: "a catch trial, whose start level was the reference",
            },
        ),
        "catch": Column(
            value=_catch,
            kind="label",
            description="Whether the trial is a catch trial",
            levels={"true": "a catch trial", "false": "a match"},
        ),
    },
    response={
        **adjusted_columns("matched_level", "{q.title} set by the participant"),
        "felt_again": Column(
            value=_felt_again,
            description="Number of times the reference was presented again during the adjustment",
        ),
    },
    intervals=TURNED,
    amplitudes=(
        *("reference_levels", "step_level", "nearest_start_level", "furthest_start_level"),
        *("lowest_level", "highest_level"),
    ),
    possible_levels=possible_levels,
    finest_level=_finest_level,
    check=check,
)
