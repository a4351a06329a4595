"""Generate the answers of one simulated person, independently of plate, clock and files.

An answer depends only on the sensations and on random numbers. The random numbers depend on the
seed, participant, run, trial and question, and on how many answers to this question in this trial
are already on disk. A resumed pilot therefore gives the same data as an uninterrupted pilot. If an
answered question is asked again, the person gives a new answer.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from slipscale.experiments.participants.simulated_people.habits import (
    LEAST_PERCENT,
    ROUND_TO_PERCENT,
    Frame,
    History,
    distorts,
    reported,
)
from slipscale.experiments.participants.simulated_people.memory import Memory
from slipscale.experiments.participants.simulated_people.own_behaviour import (
    Behaviour,
    load_behaviour,
)
from slipscale.experiments.participants.simulated_people.population import Population, curves
from slipscale.experiments.participants.simulated_people.sensation import Sensation
from slipscale.experiments.participants.simulated_people.verbal_reports import verbal_reports
from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.experiments.protocol_parts.simulated_answers import (
    SimulatedAnswer,
    misfit,
)
from slipscale.experiments.steps.questions.base import CONSENT
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.steps import Adjust, Ask, Explore, Feedback, Instruct, Rest
from slipscale.experiments.steps.trial import Value, factor_level
from slipscale.faults import UserError
from slipscale.faults.message import Message

if TYPE_CHECKING:
    from slipscale.experiments.study.run_plan import RunPlan
    from slipscale.stimuli.attributes import AttributeWords

LEAST_RATIO = 0.01  # smallest ratio that a person enters


def unanswered(protocol: str, name: str) -> str:
    """Format the error message for a question that simulated participants cannot answer."""
    return Message(
        "{protocol}: no simulated participant can answer '{name}', so the study cannot be "
        "piloted; expected a function for this question in the protocol's 'simulated'",
        protocol=protocol,
        name=name,
    )


class SimulatedRun(NamedTuple):
    """Run in which a simulated person takes part.

    Attributes
    ----------
    visit : int
        Index of the participant's run. Each run of a person uses different random numbers.
    planned : int
        Number of planned trials. If the person drops out, the last trial is selected at random
        from the planned trials.
    language : str
        Language of the verbal reports. English is used if the language is not available.
    """

    visit: int = 0
    planned: int = 0
    language: str = "en"


FIRST_RUN = SimulatedRun()


class Respondent:
    """One simulated person from a population.

    Parameters
    ----------
    seed : int
        The study's seed.
    participant : str
        The participant's label.
    run : SimulatedRun
    population : Population, optional
    answers : Mapping
        Functions that answer questions, keyed by task name and question name
        (`RunPlan.simulated_answers`).
    words : AttributeWords, optional
        Wording for the judged attribute in verbal reports (default: slipperiness).
    """

    def __init__(
        self,
        *,
        seed: int,
        participant: str,
        run: SimulatedRun = FIRST_RUN,
        population: Population | None = None,
        answers: Mapping[tuple[str, str], SimulatedAnswer] | None = None,
        words: AttributeWords | None = None,
    ) -> None:
        people = population or Population()
        self._answers = answers or {}
        # An instance of a laboratory's own class, if any, which answers instead of this object.
        self._behaviour = load_behaviour(people.behaviour) if people.behaviour else None
        self._person: SimulatedPerson = self
        if self._behaviour is not None:
            self._person = self._behaviour.made(self)
        self._key = (seed, participant)
        self._visit = ("visit", run.visit) if run.visit else ()
        self.language = run.language
        self._reports = verbal_reports(run.language, words)
        self._people = people
        self._curves = curves(people)
        self.scale_top = self.constant_stream("scale top").choice(people.scale_tops)
        self._criterion = people.criterion + people.criterion_sd * self._own("criterion")
        self._threshold = people.noise * math.exp(people.threshold_sigma * self._own("threshold"))
        self.pace = math.exp(people.pace_sigma * self._own("pace"))
        self._reading = math.exp(people.reading_sigma * self._own("reading"))
        habits = people.habits
        misread = self.constant_stream("misread").uniform() < habits.misread
        self._sensation = Sensation(people, self._own, misread=misread)
        dropout = self.constant_stream("dropout")
        self.drops_out = dropout.uniform() < habits.dropout
        self._last_trial = int(dropout.uniform() * run.planned) if self.drops_out else None
        self._distorts = distorts(habits)
        ends = people.levels[0], people.levels[-1]
        low, high = (math.log(self._curves.mean(end)) for end in ends)
        self.rises = high >= low
        self._frame = Frame(log_range=abs(high - low), middle_level=sum(ends) / 2)
        self.memory = Memory(self._curves)

    @property
    def gives_up(self) -> bool:
        """Whether the person wants to stop."""
        return self._last_trial is not None and self.memory.trials > self._last_trial

    def read(self, step: Instruct | Rest | Feedback) -> Reply:
        """Return the reply to a page, break or feedback, with its reading time."""
        if isinstance(step, Feedback):
            return Reply(response_time_s=step.duration_s)
        people = self._people
        words = len(step.text.split())
        minimum_s = 0.0
        if isinstance(step, Rest):
            minimum_s = step.minimum_s
        else:
            words += len(step.title.split())
        reading_s = people.screen_s + 60 * words / people.reading_words_per_minute * self._reading
        return Reply(response_time_s=max(reading_s, minimum_s))

    def exploration_s(self, step: Explore) -> float:
        """Return the duration of an exploration."""
        self.memory.begin(step)
        people = self._people
        deviate = self.stream("explore").normal()
        wish_s = people.exploration_s * self.pace * math.exp(people.exploration_sigma * deviate)
        wish_s = self._own_duration_s(step, wish_s)
        longest_s = math.inf if step.maximum_s is None else step.maximum_s
        return min(max(wish_s, step.minimum_s), longest_s)

    def answer(self, step: Ask) -> Reply:
        """Return the answer to a question."""
        self.memory.begin(step)
        people = self._people
        deviate = self.stream(step.name, "time").normal()
        time_s = people.answer_s * self.pace * math.exp(people.answer_sigma * deviate)
        value = self._value(step)
        time_s += step.question.movement_s(value)
        time_s = self._own_duration_s(step, time_s)
        if step.time_limit_s is not None and time_s > step.time_limit_s:
            return Reply(response_time_s=step.time_limit_s, timed_out=True)
        return Reply(value=value, response_time_s=time_s)

    def told(self, step: Ask | Adjust) -> Value:
        """Return the answer from the function that the task provides for simulated people."""
        task = step.trial.task if step.trial else getattr(step, "task", "")
        answer = self._answers.get((task, step.name))
        if answer is None:
            raise UserError(unanswered(f"task '{task}'", step.name))
        if self._behaviour is None:
            who, value = f"the simulated answer of task '{task}'", answer(step, self)
        else:
            who, person = self._behaviour.named, self._person
            value = self._behaviour.ask(lambda: answer(step, person))
        if wrong := misfit(step, value):
            raise UserError("{who} {wrong}", who=who, wrong=wrong)
        return value

    # The next members implement `SimulatedPerson`, through which protocols generate answers.

    @property
    def turned(self) -> int:
        """The number of notches by which the surface was adjusted."""
        return self.memory.turned

    @property
    def felt_again(self) -> int:
        """How often the reference was repeated."""
        return self.memory.felt_again

    @property
    def felt_level(self) -> tuple[float, ...]:
        """The levels felt in this trial, ordered by interval."""
        return tuple(felt for _, felt in sorted(self.memory.of_trial.items()))

    @property
    def impressions(self) -> tuple[float, ...]:
        """Strengths of the sensations in this trial (0 to 100), with noise."""
        each = self._threshold / math.sqrt(2)
        turned = (self.turned,) if self.turned else ()
        again = ("felt again", self.felt_again) if self.felt_again else ()
        return tuple(
            self._in_condition(self._curves.mean(felt))
            + each * self.stream("impression", interval, *turned, *again).normal()
            for interval, felt in sorted(self.memory.of_trial.items())
        )

    def usual(self, level: float) -> float:
        """Return the strength of sensation (0 to 100) that the person expects at a level."""
        return float(self._curves.mean(level))

    def pick(self, strengths: Sequence[float]) -> int:
        """Return the index of the largest strength, simulating lapses and an interval bias."""
        if self.lapses():
            return self.stream(self.memory.question, "lapse", "value").below(len(strengths))
        liking = self._people.habits.interval_bias * self._threshold
        liked = [*strengths[:-1], strengths[-1] + liking]
        return max(range(len(liked)), key=liked.__getitem__)

    def says_yes(self, strength: float) -> bool:
        """Return True if a difference exceeds the criterion, but answer at random in a lapse."""
        if self.lapses():
            return self._any_yes()
        return strength / self._threshold > self._criterion

    def estimate(self) -> float:
        """Return a magnitude estimate of the last surface, on the participant's own scale."""
        habits = self._people.habits
        percent: float = round(min(self._reported(), 100))
        if (
            habits.rounding
            and self.stream(self.memory.question, "round").uniform() < habits.rounding
        ):
            percent = round(percent / ROUND_TO_PERCENT) * ROUND_TO_PERCENT
        return round(percent / 100 * self.scale_top, 6)

    def rating(self, start: float) -> float:
        """Return this person's rating of the last surface on a line from 0 to 100."""
        place = self._sensation.place(self._reported())
        return place + self._people.habits.anchoring * (start - place)

    def ratio(self) -> float:
        """Return the strength of the last surface relative to the standard."""
        ratio = max(self._reported(), LEAST_PERCENT) / self._of_standard()
        return max(float(f"{ratio:.2g}"), LEAST_RATIO)

    def reaches(self, ratio: float) -> bool:
        """Return whether the last surface is at least ``ratio`` times as strong as the standard.

        Of the response habits, only regression, learning and misreading affect the answer.
        With regression, the person produces a ratio closer to 1.
        """
        meant: float = ratio ** (1 - self._people.habits.regression)
        return self._felt_percent() >= meant * self._of_standard()

    def lapses(self) -> bool:
        """Return whether the person answers this question at random (a lapse)."""
        lapses = self._people.habits.lapses
        return bool(lapses) and self.stream(self.memory.question, "lapse").uniform() < lapses

    def notices(self) -> bool:
        """Return whether the last two surfaces feel different to the person."""
        if self.lapses():
            return self._any_yes()
        before, after = (self._curves.mean(felt) for felt in self.memory.felt)
        noise = self.stream(self.memory.question).normal()
        return abs(before - after) / self._threshold + noise > self._criterion

    def verbal_report(self) -> str:
        """Return the person's verbal report of what disappeared when the level decreased."""
        return self.stream(self.memory.question).choice(self._reports)

    def stream(self, *purpose: str | int) -> Stream:
        """Return the random number stream for a purpose; each repetition has its own stream."""
        place = (self.memory.trial.task, self.memory.trial.number) if self.memory.trial else ("", 0)
        return self.constant_stream(*self._visit, *place, *purpose, *self.memory.again)

    # ----------------------------------------------------------------------------------------------

    def _value(self, step: Ask) -> Value:
        """Return the answer to a task question or to a question about the person."""
        if step.trial or step.task:
            return self.told(step)
        if step.name == CONSENT:
            return "yes"  # people who do not consent do not participate
        return step.question.simulated(self, step.name)

    def _own_duration_s(self, step: Explore | Ask, usual_s: float) -> float:
        """Return a step's duration: ``usual_s``, unless the package's behaviour sets another."""
        person, behaviour = self._person, self._behaviour
        if behaviour is None or not isinstance(person, Behaviour):
            return usual_s
        time_s: object = behaviour.ask(lambda: person.duration_s(step, usual_s))
        if not isinstance(time_s, int | float) or not 0 <= time_s < math.inf:
            raise UserError(
                "{behaviour}: the duration of a step is {time_s}; expected a number of seconds,"
                " 0 or more",
                behaviour=behaviour.named,
                time_s=repr(time_s),
            )
        return float(time_s)

    def _reported(self) -> float:
        """Return the sensation of the last surface (0 to 100), including response habits."""
        habits = self._people.habits
        past = self.memory.past if self._distorts or habits.learning else History()
        percent = self._felt_percent()
        if self._distorts and past.trials:
            percent = float(reported(percent, habits, past, self._frame))
        if self.lapses():
            percent = 100 * self.stream(self.memory.question, "lapse", "value").uniform()
        return percent

    def _felt_percent(self) -> float:
        """Return the sensation of the last surface (0 to 100), including the trial's noise."""
        noise = self._sensation.noise * self.stream(self.memory.question, "trial").normal()
        if self._people.habits.learning:
            noise *= max(self.memory.past.trials, 1) ** -self._people.habits.learning
        felt = self.memory.last_level
        return self._in_condition(self._sensation.percent(felt, noise))

    def _in_condition(self, percent: float) -> float:
        condition = self.memory.trial.factors if self.memory.trial else {}
        levels = {name: factor_level(value) for name, value in condition.items()}
        return self._people.in_condition(percent, levels, self._own)

    def _of_standard(self) -> float:
        """Return the sensation of the standard, felt at the start of this trial or before it."""
        return max(self._sensation.percent(self.memory.reference_level), LEAST_PERCENT)

    def _any_yes(self) -> bool:
        return self.stream(self.memory.question, "lapse", "value").uniform() < 0.5  # noqa: PLR2004

    def _own(self, what: str) -> float:
        """Return the person's value of a parameter, as a standard normal deviate."""
        return self.constant_stream(what).normal()

    def constant_stream(self, *purpose: str | int) -> Stream:
        """Return the person's random number stream for a purpose, the same stream in every run."""
        return Stream(*self._key, "simulated", *purpose)


def respondent_of(plan: RunPlan, population: Population | None = None) -> Respondent:
    """Create the simulated person for a planned run, from a population (default: `Population`)."""
    return Respondent(
        seed=plan.seed,
        participant=plan.participant,
        run=SimulatedRun(plan.visit, plan.planned_trials(), plan.language),
        population=population,
        answers=plan.simulated_answers(),
        words=plan.study.words_of(plan.language),
    )
