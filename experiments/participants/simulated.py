"""A simulated participant: feels the plate as it really vibrates, and answers like people do.

Every answer depends on (seed, participant, trial) and on what the plate does, never on how often
something was called: an interrupted and resumed pilot gives the same data as an undisturbed one.
"""

from __future__ import annotations

import math
from statistics import fmean
from typing import TYPE_CHECKING, ClassVar, Self

from experiments.participants.base import Unfinished
from experiments.participants.finger import SimulatedFinger
from experiments.participants.population import Population, mean_sensation, sensation
from experiments.protocols.randomisation import Stream
from experiments.protocols.steps import (
    CONSENT,
    Ask,
    ChoiceQuestion,
    Explore,
    Feedback,
    Instruct,
    Reply,
    Rest,
    Value,
    WholeNumberQuestion,
)
from faults import UserError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from types import TracebackType

    from experiments.participants.base import Kind, Turn, Watch
    from experiments.protocols.simulation import SimulatedAnswer
    from experiments.protocols.steps import Adjust, ParticipantStep, Trial
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
TURN_S = 0.6  # from one notch to the next: turn, feel, decide
MOST_TURNS = 1000  # more than the wheel has between any bounds: who cannot decide stops


def unanswered(task: str, name: str) -> str:
    """Return the sentence about a question that nobody answers in a pilot."""
    return (
        f"protocol '{task}': no simulated participant can answer '{name}', so there is no pilot "
        f"of it; expected its 'simulated' to say who answers"
    )


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
    answers : Mapping
        Who answers the questions of the run's tasks, by task and name
        (`RunPlan.simulated_answers`).
    frame_s : float, optional
        How often ``watch`` is called during an exploration, where a source measures the finger.
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
        answers: Mapping[tuple[str, str], SimulatedAnswer] | None = None,
        frame_s: float | None = None,
    ) -> None:
        self._answers = answers or {}
        self.language = language
        self._key = (seed, participant)
        self._visit = ("visit", visit) if visit else ()
        self._feel = feel
        self._clock = clock
        self._population = population or Population()
        self._frame_s = frame_s
        self.finger = SimulatedFinger(self._stream("finger"))
        self.scale_top = self._stream("scale top").choice(self._population.scale_tops)
        # The two surfaces felt last: a difference is between them.
        self._felt: tuple[float, float] = (0.0, 0.0)
        # What was felt in one trial, by its interval.
        self._trial: Trial | None = None
        self._of_trial: dict[int, float] = {}
        self.turned = 0
        self._name = ""

    def perform(self, step: ParticipantStep, watch: Watch) -> Reply:
        """Read, explore, answer or rest; see `experiments.participants.base.Participant`."""
        watch()
        onset_s = self._clock.now()
        if isinstance(step, Explore):
            reply = self._explore(step, watch)
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

    def adjust(self, step: Adjust, turn: Turn, watch: Watch) -> Reply:
        """Turn until the function that answers says that it will do."""
        watch()
        onset_s = self._clock.now()
        limit_s = math.inf if step.time_limit_s is None else step.time_limit_s
        self._begin(step.trial)
        self.turned = 0
        timed_out = False
        for _ in range(MOST_TURNS):
            self._clock.sleep(TURN_S)
            if self._clock.now() - onset_s > limit_s:
                timed_out = True
                break
            self._of_trial[step.interval] = round(self._feel(), FELT_DIGITS)
            notches = int(self._told(step) or 0)
            if not notches:
                break
            turn(notches)
            self.turned += notches
            watch()
        return Reply(
            onset_s=onset_s,
            response_time_s=None if timed_out else self._clock.now() - onset_s,
            time_source="simulated",
            timed_out=timed_out,
        )

    def hold(self, _text: str, until: Callable[[], bool]) -> None:
        """Wait."""
        while not until():
            self._clock.sleep(0.1)

    # What a protocol may know, see `experiments.protocols.simulation.SimulatedPerson` -------------

    @property
    def felt_um_pp(self) -> tuple[float, ...]:
        """What was felt in this trial, in the order of its intervals."""
        return tuple(felt for _, felt in sorted(self._of_trial.items()))

    @property
    def impressions(self) -> tuple[float, ...]:
        """How strong each seemed: the noise of two of them makes that of a difference."""
        each = self._population.noise / math.sqrt(2)
        turned = (self.turned,) if self.turned else ()
        return tuple(
            mean_sensation(felt) + each * self.stream("impression", interval, *turned).normal()
            for interval, felt in sorted(self._of_trial.items())
        )

    def pick(self, strengths: Sequence[float]) -> int:
        """Return the place of the largest."""
        return max(range(len(strengths)), key=strengths.__getitem__)

    def says_yes(self, strength: float) -> bool:
        """Return whether a difference of impressions passes the criterion."""
        return strength / self._population.noise > self._population.criterion

    def estimate(self) -> float:
        """Return a magnitude estimate on the participant's own scale."""
        felt = self._felt[1]
        people = self._population
        deviate = (
            math.sqrt(people.shared) * self._stream("shared").normal()
            + math.sqrt(people.own) * self._stream("own", f"{felt:.1f}").normal()
            + math.sqrt(people.trial_to_trial) * self.stream("trial").normal()
        )
        return round(round(sensation(felt, deviate)) / 100 * self.scale_top, 6)

    def notices(self) -> bool:
        """Return whether the last two surfaces feel different."""
        before, after = (mean_sensation(felt) for felt in self._felt)
        people = self._population
        noise = self.stream(self._name).normal()
        return abs(before - after) / people.noise + noise > people.criterion

    def verbal_report(self) -> str:
        """Return what people say has been removed."""
        return self.stream(self._name).choice(VERBAL_REPORTS[self.language])

    def stream(self, *purpose: str | int) -> Stream:
        """Return random numbers for one purpose in this trial."""
        place = (self._trial.task, self._trial.number) if self._trial else ("", 0)
        return self._stream(*self._visit, *place, *purpose)

    # ----------------------------------------------------------------------------------------------

    def _read(self, step: Instruct | Rest | Feedback) -> Reply:
        if isinstance(step, Feedback):
            return Reply(response_time_s=step.duration_s)
        minimum_s = step.minimum_s if isinstance(step, Rest) else 0.0
        return Reply(response_time_s=max(READING_S, minimum_s))

    def _explore(self, step: Explore, watch: Watch) -> Reply:
        """Stroke the surface for a while and remember how it felt."""
        self._begin(step.trial)
        interval = () if step.interval is None else (step.interval,)
        stream = self.stream("explore", *interval)
        people = self._population
        wish_s = people.exploration_s * math.exp(people.exploration_sigma * stream.normal())
        longest_s = math.inf if step.maximum_s is None else step.maximum_s
        duration_s = min(max(wish_s, step.minimum_s), longest_s)
        moments = self.stream("touch", *interval)
        begun_s = self._clock.now()
        touches = []
        self.finger.strokes(begun_s, self.stream("finger", *interval))
        for touch in range(TOUCHES):
            share = (touch + moments.uniform()) / TOUCHES
            self._pass_until(begun_s + share * duration_s, watch)
            touches.append(round(self._feel(), FELT_DIGITS))
        self._pass_until(begun_s + duration_s, watch)
        if self._frame_s:
            watch()  # the last samples, before the finger leaves
        self.finger.lifts()
        felt = round(fmean(touches), FELT_DIGITS)
        self._felt = (self._felt[1], felt)
        self._of_trial[step.interval or 1] = felt
        return Reply(response_time_s=duration_s)

    def _pass_until(self, time_s: float, watch: Watch) -> None:
        """Let the time pass; where the finger is measured, watch at every frame."""
        while self._frame_s and self._clock.now() + self._frame_s < time_s:
            self._clock.sleep(self._frame_s)
            watch()
        self._clock.sleep(time_s - self._clock.now())

    def _answer(self, step: Ask) -> Reply:
        self._begin(step.trial)
        stream = self.stream(step.name, "time")
        people = self._population
        time_s = people.answer_s * math.exp(people.answer_sigma * stream.normal())
        if step.time_limit_s is not None and time_s > step.time_limit_s:
            return Reply(response_time_s=step.time_limit_s, timed_out=True)
        return Reply(value=self._value(step), response_time_s=time_s)

    def _value(self, step: Ask) -> Value:
        """Return the answer to a question."""
        if step.trial or step.task:
            return self._told(step)
        question, stream = step.question, self.stream(step.name)
        if isinstance(question, WholeNumberQuestion):
            span = question.maximum - question.minimum + 1
            return float(question.minimum + int(stream.uniform() * span))
        if step.name == CONSENT:
            return "yes"  # who does not agree is no participant
        if isinstance(question, ChoiceQuestion):
            return stream.choice(question.options)[0]
        raise TypeError(f"no simulated answer to {type(question).__name__}")

    def _told(self, step: Ask | Adjust) -> Value:
        """Return what the task's own function answers."""
        task = step.trial.task if step.trial else getattr(step, "task", "")
        answer = self._answers.get((task, step.name))
        if answer is None:
            raise UserError(unanswered(task, step.name))
        self._name = step.name
        return answer(step, self)

    def _begin(self, trial: Trial | None) -> None:
        """Note the trial that a step belongs to: another one's impressions are gone."""
        if trial != self._trial:
            self._trial, self._of_trial, self.turned = trial, {}, 0

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
