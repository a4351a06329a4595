"""Trials that present some surfaces in intervals and ask one question about them, in a fixed plan.

What `constant_stimuli` and `paired_comparison` share; what is compared with what is theirs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from pydantic import Field

from experiments.protocols.base import AtLeastOne, Count, Switch
from experiments.protocols.pacing import PacedOptions
from experiments.protocols.repeating import Repeating, part_over
from experiments.protocols.steps import (
    Ask,
    EndTrial,
    Instruct,
    Phase,
    Present,
    Reply,
    Silence,
    Trial,
    Value,
    Voided,
)

if TYPE_CHECKING:
    from collections.abc import Generator, Mapping, Sequence

    from experiments.protocols.base import Context
    from experiments.protocols.randomisation import Stream
    from experiments.protocols.steps import Answer, Question, Rest, Step, Steps
    from stimuli.surface import Surface


class ComparingOptions(PacedOptions):
    """What a study may set for tasks in which surfaces are compared after a plan."""

    practice: Count = Field(
        default=3,
        description="Trials with surfaces that are easily told apart before, for practice; "
        "recorded, not analysed.",
        json_schema_extra={"unit": "trials"},
    )
    catch_trials: Count = Field(
        default=0,
        description="Trials with surfaces that are easily told apart among the others, to see "
        "whether attention holds.",
        json_schema_extra={"unit": "trials"},
    )
    rest_every_trials: AtLeastOne | None = Field(
        default=25,
        description="A rest after so many trials.",
        json_schema_extra={"unit": "trials"},
    )
    repeat_timed_out: Switch = Field(
        default=True, description="Whether a timed-out trial is repeated, once."
    )


class Shown(NamedTuple):
    """What makes a trial: the surfaces in their order, and the protocol's own columns."""

    phase: Phase
    surfaces: tuple[Surface, ...]
    factors: Mapping[str, Value]


def with_catch_trials(
    planned: Sequence[Shown], catch_trials: Sequence[Shown], stream: Stream
) -> list[Shown]:
    """Return the plan with catch trials at any places among it, each choice as likely."""
    marks = stream.shuffled([False] * len(planned) + [True] * len(catch_trials))
    trials, catches = iter(planned), iter(catch_trials)
    return [next(catches) if catch else next(trials) for catch in marks]


class Comparing(Repeating[Shown]):
    """The trials of a run.

    Parameters
    ----------
    options, context
        The run's.
    texts : str
        What the keys of the task's own texts begin with.
    question : Question
        Asked after the last interval.
    practice, main : sequence of Shown
        The plan.
    """

    def __init__(
        self,
        options: ComparingOptions,
        context: Context,
        *,
        texts: str,
        question: Question,
        practice: Sequence[Shown],
        main: Sequence[Shown],
    ) -> None:
        super().__init__(len(practice) + len(main))
        self.options = options
        self.context = context
        self._texts = texts
        self._question = question
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

    def between(self) -> Steps:
        """Yield the rest after so many trials."""
        every = self.options.rest_every_trials
        if every and self.number % every == 0 and self.number < self.total:
            yield self.rest()

    def rest(self) -> Rest:
        """Return the break screen for now."""
        text = self.context.texts["session.rest"]
        return self.options.rest(text, done=self.number, total=self.total)

    def trial(
        self, condition: Shown, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield one trial; return the numbers of the trials to be repeated."""
        trial = Trial(
            task=self.context.task,
            number=number,
            total=self.total,
            phase=condition.phase,
            factors=condition.factors,
            repeats=repeats,
        )
        for place, surface in enumerate(condition.surfaces, start=1):
            yield from felt(self.options, self.context, surface, trial, place)
        reply = yield Ask(
            name="response",
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


def felt(
    options: PacedOptions, context: Context, surface: Surface, trial: Trial, interval: int
) -> Steps:
    """Yield an interval: a surface, its exploration, silence."""
    yield Present(surface=surface, trial=trial, interval=interval)
    text = context.texts["comparing.explore"].format(number=interval)
    yield options.explore(text, trial, interval=interval)
    yield Silence(trial=trial, interval=interval)


def truth(value: bool | None) -> str | None:
    """Return a yes or no as a cell of a table holds it."""
    return None if value is None else "true" if value else "false"
