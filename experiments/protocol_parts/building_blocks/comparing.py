"""Code shared by comparison tasks, whose trials present surfaces in intervals.

`Comparing` runs a fixed plan of trials, each with one question.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from typing import NamedTuple

from slipscale.experiments.protocol_parts.base import Context, Count, Switch
from slipscale.experiments.protocol_parts.building_blocks.pacing import RestedOptions
from slipscale.experiments.protocol_parts.building_blocks.repeating import (
    Condition,
    Repeating,
    part_over,
)
from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.experiments.steps.columns import Column, Given, TrialRecord
from slipscale.experiments.steps.questions.base import Question, Sought
from slipscale.experiments.steps.replies import Answer, Reply, Voided
from slipscale.experiments.steps.steps import (
    Ask,
    EndTrial,
    Explore,
    Instruct,
    Present,
    Silence,
    Step,
    Steps,
)
from slipscale.experiments.steps.trial import Phase, Trial, Value
from slipscale.faults import UserError
from slipscale.faults.frozen_table import setting
from slipscale.stimuli.quantity import Quantity
from slipscale.stimuli.surface import Stimulus

PAIR = 2


class ComparingOptions(RestedOptions):
    """Options for tasks that compare surfaces according to a plan."""

    practice: Count = setting(
        3,
        "Number of practice trials before the main trials, with easily distinguished surfaces; "
        "recorded but not analysed.",
        unit="trials",
    )
    catch_trials: Count = setting(
        0,
        "Number of catch trials, with easily distinguished surfaces, to check attention.",
        unit="trials",
    )
    repeat_timed_out: Switch = setting(True, "Whether a timed-out trial is repeated once.")


class Shown(NamedTuple):
    """The definition of a trial: its surfaces in order, and the protocol's own columns."""

    phase: Phase
    surfaces: tuple[Stimulus, ...]
    factors: Mapping[str, Value]


def with_catch_trials(
    planned: Sequence[Condition], catch_trials: Sequence[Condition], stream: Stream
) -> list[Condition]:
    """Insert catch trials at random positions; all placements are equally likely."""
    marks = stream.shuffled([False] * len(planned) + [True] * len(catch_trials))
    trials, catches = iter(planned), iter(catch_trials)
    return [next(catches) if catch else next(trials) for catch in marks]


def in_both_orders(
    groups: Sequence[tuple[Stimulus, ...]], repetitions: int, context: Context
) -> list[Shown]:
    """Return trials that present each group once per repetition, in random order.

    The order of the surfaces in a group is reversed from each repetition to the next.
    """
    stream = context.stream(context.task, "main")
    begins = [stream.below(2) for _ in groups]  # reversed in odd repetitions
    return [
        Shown(
            "main",
            groups[each] if (begins[each] + repetition) % 2 else groups[each][::-1],
            {"catch": False},
        )
        for repetition in range(repetitions)
        for each in stream.shuffled(range(len(groups)))
    ]


def the_two_ends(
    easy: tuple[Stimulus, ...], context: Context, phase: Phase, count: int
) -> list[Shown]:
    """Return trivially easy trials: the given surfaces, randomly in forward or reverse order."""
    stream = context.stream(context.task, "easy", phase)
    turned = [stream.below(2) for _ in range(count)]
    return [Shown(phase, easy[::-1] if turn else easy, {"catch": True}) for turn in turned]


def name_of(surface: Stimulus) -> str:
    """Return the name of a surface in the data: its texture's name, or its level."""
    return surface.name or f"{surface.level:g}"


def surface_name(record: TrialRecord) -> str | None:
    """Return the name of the presented surface, if one was presented."""
    return name_of(record.surface) if record.surface else None


def sought(quantity: Quantity, sign: int = 1) -> Sought:
    """Return whether a question asks for the "most" or the "least" of the judged attribute.

    The question asks for the surface with the higher level if ``sign`` is 1, and for the surface
    with the lower level if ``sign`` is -1. For some quantities, the judged attribute decreases with
    the level.
    """
    return "least" if (sign < 0) != quantity.falls else "most"


def surface_names(*names: str) -> dict[str, Column]:
    """Return one column per interval, with the name of the surface presented in it."""
    return {
        name: Column(
            value=Given(_name_in, (interval,)),
            kind="label",
            description=f"Surface in interval {interval}, given as its {{q.name}} in "
            f"{{q.unit_in_full}} or as the texture's name",
        )
        for interval, name in enumerate(names, start=1)
    }


def _name_in(record: TrialRecord, interval: int) -> str | None:
    shown = record.intervals.get(interval)
    return name_of(shown.surface) if shown else None


def enough_surfaces(_options: object, context: Context, protocol: str, fewest: int) -> None:
    """Raise `UserError` if a study has too few surfaces."""
    if (available := len(context.surfaces)) < fewest:
        raise UserError(
            "{protocol} needs {fewest} surfaces, but the study has {available}",
            protocol=protocol,
            fewest=fewest,
            available=available,
        )


class IntervalTask(Repeating[Condition]):
    """One run of a task with intervals and regular rests.

    Parameters
    ----------
    total : int
        Number of trials in the task if no trial is repeated.
    options, context
        The run's options and context.
    """

    def __init__(self, total: int, options: RestedOptions, context: Context) -> None:
        super().__init__(total)
        self._pace = options
        self.context = context

    def between(self) -> Steps:
        """Yield a rest if one is due."""
        if self.number % self._pace.rest_every_trials == 0 and self.number < self.total:
            text = self.context.texts["session.rest"]
            yield self._pace.rest(text, done=self.number, total=self.total)

    def interval(self, surface: Stimulus, trial: Trial, number: int) -> Steps:
        """Yield the steps of an interval: present a surface, explore it, switch the plate off."""
        yield Present(surface=surface, trial=trial, interval=number)
        yield self.exploration(trial, number)
        yield Silence(trial=trial, interval=number)

    def exploration(self, trial: Trial, number: int) -> Explore:
        """Return the step in which the participant explores the surface of an interval."""
        text = self.context.texts["comparing.explore"].format(number=number)
        return self._pace.explore(text, trial, interval=number)


class Comparing(IntervalTask[Shown]):
    """One run of a comparison task.

    Parameters
    ----------
    options, context
        The run's options and context.
    texts : str
        Prefix of the task's text keys.
    question : Question
        Question asked after the last interval.
    practice, main : sequence of Shown
        The planned trials.
    """

    def __init__(
        self,
        options: ComparingOptions,
        context: Context,
        *,
        texts: str,
        question: Question,
        name: str = "response",
        practice: Sequence[Shown],
        main: Sequence[Shown],
    ) -> None:
        super().__init__(len(practice) + len(main), options, context)
        self.options = options
        self._texts = texts
        self._question = question
        self._name = name
        self._practice = practice
        self._main = main

    def steps(self) -> Steps:
        """Yield the steps of a run."""
        texts = self.context.texts
        yield Instruct(
            title=texts[f"{self._texts}.title"], text=texts[f"{self._texts}.instructions"]
        )
        if self._practice:
            yield Instruct(text=texts["comparing.practice"])
            yield from self.block(self._practice)
            yield from self.close(lambda: Instruct(text=texts["comparing.main"]))
        yield from self.block(self._main)
        yield from self.close(lambda: part_over(texts))

    def trial(
        self, condition: Shown, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield a trial's steps, and return the numbers of the trials to repeat."""
        trial = Trial(
            task=self.context.task,
            number=number,
            total=self.total,
            phase=condition.phase,
            factors=condition.factors,
            repeats=repeats,
        )
        for place, surface in enumerate(condition.surfaces, start=1):
            yield from self.interval(surface, trial, place)
        reply = yield Ask(
            name=self._name,
            question=self._question,
            trial=trial,
            time_limit_s=self.options.response_time_limit_s,
        )
        voided = yield EndTrial(trial=trial)
        again = voided.trials if isinstance(voided, Voided) else ()
        missed = isinstance(reply, Reply) and reply.timed_out and number not in again
        if missed and self.options.repeat_timed_out and repeats is None:
            again = (*again, number)
        return again


#: The design column for tasks with a fixed plan of trials.
DESIGN: Mapping[str, Column] = {
    "catch": Column(
        kind="label",
        description="Whether the trial is a practice or catch trial instead of a planned trial",
        levels={"true": "not part of the plan", "false": "part of the plan"},
    ),
}
