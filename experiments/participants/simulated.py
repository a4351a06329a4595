"""A simulated participant: feels the plate as it really vibrates, and answers like people do.

Every answer depends on (seed, participant, trial) and on what the plate does, never on how often
something was called: an interrupted and resumed pilot gives the same data as an undisturbed one.
"""

from __future__ import annotations

import math
from statistics import fmean
from typing import TYPE_CHECKING, ClassVar, Self

from experiments.participants.base import Unfinished
from experiments.participants.population import Population, mean_sensation, sensation
from experiments.protocols.randomisation import Stream
from experiments.protocols.steps import (
    CONSENT,
    Ask,
    ChoiceQuestion,
    Explore,
    Instruct,
    NumberQuestion,
    Reply,
    Rest,
    TextQuestion,
    Value,
    WholeNumberQuestion,
    YesNoQuestion,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from types import TracebackType

    from experiments.participants.base import Kind, Watch
    from experiments.protocols.steps import ParticipantStep
    from hardware.clock import Clock

# What people say has been removed; the first is the paper's ("less slippery", Section IV-B).
VERBAL_REPORTS: Mapping[str, tuple[str, ...]] = {
    "en": (
        "less slippery",
        "it is less slippery",
        "it got rougher",
        "less smooth, it sticks more",
        'the "oily" feeling is gone',
    ),
    "fr": (
        "moins glissant",
        "c'est moins glissant",
        "plus rugueux",
        "moins lisse, ça accroche",
        "l'effet « huileux » a disparu",
    ),
}
READING_S = 4.0
# The plate reads a fraction of a micrometre differently from moment to moment; a finger does not
# tell 2.298 from 2.302 µm, and answers must not depend on the last digit.
FELT_DIGITS = 2
# A texture changes under the finger: it is felt at so many moments of the stroke, and rated as
# the mean. A plain surface is the same at each.
TOUCHES = 32


class SimulatedParticipant:
    """One of the simulated population.

    Parameters
    ----------
    seed : int
        The study's seed.
    participant : str
        The participant's label.
    feel : callable
        Returns the plate's vibration now, µm peak to peak: what is felt is the plate itself, not
        what the protocol believes of it.
    clock : Clock
        A virtual clock, so that nobody waits.
    language : str
        Of the verbal reports.
    population : Population, optional
    visit : int
        Which of the participant's runs it is: the person stays the same, trials are others.
    """

    kind: ClassVar[Kind] = "simulated"
    unfinished = Unfinished()

    def __init__(
        self,
        *,
        seed: int,
        participant: str,
        feel: Callable[[], float],
        clock: Clock,
        language: str = "en",
        population: Population | None = None,
        visit: int = 0,
    ) -> None:
        self._key = (seed, participant)
        self._visit = ("visit", visit) if visit else ()
        self._feel = feel
        self._clock = clock
        self._language = language
        self._population = population or Population()
        self.scale_top = self._stream("scale top").choice(self._population.scale_tops)
        # The two surfaces felt last: a difference is between them.
        self._felt: tuple[float, float] = (0.0, 0.0)

    def perform(self, step: ParticipantStep, watch: Watch) -> Reply:
        """Read, explore, answer or rest; see `experiments.participants.base.Participant`."""
        watch()
        onset_s = self._clock.now()
        if isinstance(step, Explore):
            reply = self._explore(step)
        else:
            reply = self._answer(step) if isinstance(step, Ask) else self._read(step)
            self._clock.sleep(reply.response_time_s or 0.0)
        watch()
        return Reply(
            value=reply.value,
            onset_s=onset_s,
            response_time_s=None if reply.timed_out else reply.response_time_s,
            time_source="simulated",
            timed_out=reply.timed_out,
        )

    def hold(self, _text: str, until: Callable[[], bool]) -> None:
        """Wait."""
        while not until():
            self._clock.sleep(0.1)

    def _read(self, step: Instruct | Rest) -> Reply:
        minimum_s = step.minimum_s if isinstance(step, Rest) else 0.0
        return Reply(response_time_s=max(READING_S, minimum_s))

    def _explore(self, step: Explore) -> Reply:
        """Stroke the surface for a while and remember how it felt."""
        stream = self._for(step, "explore")
        people = self._population
        wish_s = people.exploration_s * math.exp(people.exploration_sigma * stream.normal())
        longest_s = math.inf if step.maximum_s is None else step.maximum_s
        duration_s = min(max(wish_s, step.minimum_s), longest_s)
        moments = self._for(step, "touch")
        begun_s = self._clock.now()
        touches = []
        for touch in range(TOUCHES):
            share = (touch + moments.uniform()) / TOUCHES
            self._clock.sleep(begun_s + share * duration_s - self._clock.now())
            touches.append(round(self._feel(), FELT_DIGITS))
        self._clock.sleep(begun_s + duration_s - self._clock.now())
        self._felt = (self._felt[1], round(fmean(touches), FELT_DIGITS))
        return Reply(response_time_s=duration_s)

    def _answer(self, step: Ask) -> Reply:
        stream = self._for(step, step.name, "time")
        people = self._population
        time_s = people.answer_s * math.exp(people.answer_sigma * stream.normal())
        if step.time_limit_s is not None and time_s > step.time_limit_s:
            return Reply(response_time_s=step.time_limit_s, timed_out=True)
        return Reply(value=self._value(step), response_time_s=time_s)

    def _value(self, step: Ask) -> Value:
        """Return the answer to a question."""
        question = step.question
        stream = self._for(step, step.name)
        if isinstance(question, NumberQuestion):
            return self.scale_top if question.positive else self._estimate(step)
        if isinstance(question, YesNoQuestion):
            return self._difference(stream)
        if isinstance(question, TextQuestion):
            return stream.choice(VERBAL_REPORTS[self._language])
        if isinstance(question, WholeNumberQuestion):
            span = question.maximum - question.minimum + 1
            return float(question.minimum + int(stream.uniform() * span))
        if step.name == CONSENT:
            return "yes"  # who does not agree is no participant
        if isinstance(question, ChoiceQuestion):
            return stream.choice(question.options)[0]
        raise TypeError(f"no simulated answer to {type(question).__name__}")

    def _estimate(self, step: Ask) -> float:
        """Return a magnitude estimate on the participant's own scale."""
        felt = self._felt[1]
        people = self._population
        deviate = (
            math.sqrt(people.shared) * self._stream("shared").normal()
            + math.sqrt(people.own) * self._stream("own", f"{felt:.1f}").normal()
            + math.sqrt(people.trial_to_trial) * self._for(step, "trial").normal()
        )
        return round(round(sensation(felt, deviate)) / 100 * self.scale_top, 6)

    def _difference(self, stream: Stream) -> bool:
        """Return whether the last two surfaces feel different."""
        before, after = (mean_sensation(felt) for felt in self._felt)
        people = self._population
        return abs(before - after) / people.noise + stream.normal() > people.criterion

    def _for(self, step: ParticipantStep, *purpose: str) -> Stream:
        """Return random numbers for one purpose in one trial."""
        trial = step.trial
        place = (trial.task, trial.number) if trial else ("", 0)
        return self._stream(*self._visit, *place, *purpose)

    def _stream(self, *purpose: str | int) -> Stream:
        return Stream(*self._key, "simulated", *purpose)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        return None
