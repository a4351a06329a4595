"""Code shared by tasks in which surfaces are rated one by one in random order.

The order is generated in blocks, starting with practice. Voided trials are repeated under new
numbers at the end of their block; timed-out trials are also repeated if the study requests it.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

from slipscale.experiments.protocol_parts.base import AtLeastOne, Context, Count, Switch
from slipscale.experiments.protocol_parts.building_blocks.pacing import PacedOptions
from slipscale.experiments.protocol_parts.building_blocks.repeating import Repeating, part_over
from slipscale.experiments.protocol_parts.ordering.orders import (
    Rule,
    practice_order,
    presentation_order,
)
from slipscale.experiments.steps.columns import Column, TrialRecord
from slipscale.experiments.steps.questions.base import Question
from slipscale.experiments.steps.replies import Answer, Reply, Voided
from slipscale.experiments.steps.steps import (
    Ask,
    EndTrial,
    Instruct,
    Present,
    Rest,
    Silence,
    Step,
    Steps,
)
from slipscale.experiments.steps.trial import Phase, Trial, Value
from slipscale.faults.frozen_table import setting
from slipscale.stimuli.surface import Stimulus


class RatedOptions(PacedOptions):
    """Options for tasks in which surfaces are rated one by one."""

    repetitions: AtLeastOne = setting(
        1, "Number of ratings per surface.", unit="ratings per surface"
    )
    practice: Count = setting(
        1,
        "Number of practice ratings per surface, before the main trials; recorded but not "
        "analysed.",
        unit="ratings per surface",
    )
    randomisation: Rule = setting(
        "blocked",
        "Order of the surfaces. simple: all trials are shuffled together; blocked: each repetition "
        "is shuffled separately; williams: rows of a Williams square, which balances first-order "
        "carry-over.",
    )
    no_immediate_repeat: Switch = setting(
        True,
        "Whether a surface is never presented twice in a row, including between the last practice "
        "trial and the first main trial.",
    )
    repeat_timed_out: Switch = setting(True, "Whether a timed-out trial is repeated once.")
    rest_every_trials: AtLeastOne | None = setting(
        None, "Number of trials between rests; default: a rest after each block.", unit="trials"
    )

    @property
    def rounds(self) -> int:
        """Number of ratings per surface, including practice."""
        return self.practice + self.repetitions


def surface_trials(options: RatedOptions, context: Context) -> int:
    """Return the number of ratings of the study's surfaces, including practice."""
    return len(context.surfaces) * options.rounds


class Presentation(NamedTuple):
    """The definition of a trial: its surface, block and phase, and the protocol's own columns."""

    block: int
    phase: Phase
    surface: Stimulus
    factors: Mapping[str, Value] = MappingProxyType({})


Blocks = list[tuple["Phase", list[int]]]


def order_blocks(conditions: int, options: RatedOptions, context: Context) -> Blocks:
    """Return blocks of conditions in presentation order, starting with practice."""
    main = presentation_order(
        conditions,
        options.repetitions,
        options.randomisation,
        stream=context.stream(context.task, "main"),
        shared=lambda group, turn: context.shared_stream(context.task, "main", group, turn),
        place=context.place,
        no_immediate_repeat=options.no_immediate_repeat,
    )
    practice = practice_order(
        conditions,
        options.practice,
        stream=context.stream(context.task, "practice"),
        following=main[0][0] if options.no_immediate_repeat else None,
    )
    return [
        *(("practice", block) for block in practice),
        *(("main", block) for block in main),
    ]


def surface_blocks(
    surfaces: Sequence[Stimulus], options: RatedOptions, context: Context
) -> list[list[Presentation]]:
    """Return blocks of surfaces in presentation order, starting with practice."""
    order = order_blocks(len(surfaces), options, context)
    return [
        [Presentation(number, phase, surfaces[each]) for each in block]
        for number, (phase, block) in enumerate(order, start=1)
    ]


def with_catch_trials(
    planned: list[list[Presentation]], catches: Sequence[Presentation], context: Context
) -> list[list[Presentation]]:
    """Insert catch trials at random positions; a column marks the catch trials.

    Catch trials can occur anywhere among the main trials, and all placements are equally likely. A
    catch trial belongs to the block in which it occurs.
    """
    main = sum(each.phase == "main" for block in planned for each in block)
    stream = context.stream(context.task, "catch")
    marks = iter(stream.shuffled([False] * main + [True] * len(catches)))
    left = iter(catches)

    def marked(each: Presentation, block: int, *, catch: bool) -> Presentation:
        return each._replace(block=block, factors={**each.factors, "catch": catch})

    mixed = []
    for block in planned:
        own = []
        for each in block:
            while each.phase == "main" and next(marks):
                own.append(marked(next(left), each.block, catch=True))
            own.append(marked(each, each.block, catch=False))
        mixed.append(own)
    mixed[-1] += [marked(each, mixed[-1][-1].block, catch=True) for each in left]
    return mixed


class RatedSurfaces(Repeating[Presentation]):
    """One run of a rating task.

    Parameters
    ----------
    options, context
        The run's options and context.
    planned : sequence of sequence of Presentation
        Blocks of trials; practice blocks come first.
    """

    def __init__(
        self,
        options: RatedOptions,
        context: Context,
        planned: Sequence[Sequence[Presentation]],
    ) -> None:
        super().__init__(sum(len(block) for block in planned))
        self.order = options
        self.context = context
        self.planned = planned

    def rest(self) -> Rest:
        """Return the break screen with the current progress."""
        text = self.context.texts["session.rest"]
        return self.order.rest(text, done=self.number, total=self.total)

    @property
    def rest_due(self) -> bool:
        """Whether a rest follows the completed trial."""
        every = self.order.rest_every_trials
        return every is not None and self.number % every == 0 and self.number < self.total

    def between(self) -> Steps:
        """Yield a rest if one is due."""
        if self.rest_due:
            yield self.rest()

    def steps(self, *, practice: str, main: str) -> Steps:
        """Yield all blocks, with instructions before and after practice (if there is practice)."""
        texts, planned = self.context.texts, self.planned
        if planned[0][0].phase == "practice":
            yield Instruct(text=practice)
        for number, block in enumerate(planned, start=1):
            yield from self.block(block)
            following = planned[number][0].phase if number < len(planned) else None
            if following is None:
                yield from self.close(lambda: part_over(texts))
            elif following != block[0].phase:
                yield from self.close(lambda: Instruct(text=main))
            elif self.order.rest_every_trials is None:
                yield from self.close(self.rest)

    def numbered(
        self,
        condition: Presentation,
        number: int,
        repeats: int | None,
        factors: Mapping[str, Value],
    ) -> Trial:
        """Return a trial. Its factors are the block, the condition's factors and ``factors``."""
        return Trial(
            task=self.context.task,
            number=number,
            total=self.total,
            phase=condition.phase,
            factors={"block": condition.block, **condition.factors, **factors},
            repeats=repeats,
        )

    def rated(
        self,
        condition: Presentation,
        trial: Trial,
        *,
        explore: str,
        name: str,
        question: Question,
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield a surface, its exploration and its rating; return the trials to repeat."""
        reply = yield from self.asked(
            condition, trial, explore=explore, name=name, question=question
        )
        return (yield from self.over(trial, reply))

    def asked(
        self,
        condition: Presentation,
        trial: Trial,
        *,
        explore: str,
        name: str,
        question: Question,
    ) -> Generator[Step, Answer, Answer]:
        """Yield a surface, its exploration and the question; return the reply."""
        options = self.order
        yield Present(surface=condition.surface, trial=trial)
        yield options.explore(explore, trial)
        if options.exploration_maximum_s is not None:
            yield Silence(trial=trial)
        reply = yield Ask(
            name=name,
            question=question,
            trial=trial,
            time_limit_s=options.response_time_limit_s,
        )
        # Silence between surfaces, so that the participant does not feel the transition.
        yield Silence(trial=trial)
        return reply

    def over(self, trial: Trial, reply: Answer) -> Generator[Step, Answer, tuple[int, ...]]:
        """End a trial, and return the numbers of the trials to repeat."""
        voided = yield EndTrial(trial=trial)
        again = voided.trials if isinstance(voided, Voided) else ()
        missed = isinstance(reply, Reply) and reply.timed_out and trial.number not in again
        if missed and self.order.repeat_timed_out and trial.repeats is None:
            again = (*again, trial.number)
        return again


BLOCK = {
    "block": Column(description="Number of the block, from 1; practice blocks are counted"),
}


def _texture(record: TrialRecord) -> str | None:
    return (record.surface and record.surface.name) or None


TEXTURE = {
    "texture": Column(
        value=_texture,
        kind="label",
        description=(
            "Name of the texture in the study file; n/a for a surface with a single {q.name}"
        ),
    ),
}
