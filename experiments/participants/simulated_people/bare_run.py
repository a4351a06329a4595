"""Run a protocol with a simulated person, for planning, without a session, plate or journal.

The questions and answers are the same as in a session on the mock plate, but a run is many times
faster. A run differs from a session in two details. The person feels the mean amplitude of a
texture; in a session, the person feels the amplitudes at several points of the stroke. In an
adjustment, each notch takes only the time that the person needs; in a session, the plate also needs
time to settle.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from slipscale.experiments.participants.simulated_people.in_session import (
    FELT_DIGITS,
    turned_until_content,
)
from slipscale.experiments.participants.simulated_people.respondent import Respondent, respondent_of
from slipscale.experiments.steps.replies import (
    FEEL_AGAIN,
    Adjusted,
    Answer,
    Presented,
    Reply,
    Voided,
)
from slipscale.experiments.steps.steps import (
    Adjust,
    Ask,
    EndBlock,
    EndTrial,
    Explore,
    Feedback,
    Instruct,
    Present,
    Rest,
    Silence,
    Step,
)
from slipscale.hardware.clock import VirtualClock
from slipscale.stimuli.varied import Varied

if TYPE_CHECKING:
    from slipscale.experiments.participants.simulated_people.population import Population
    from slipscale.experiments.study.run_plan import RunPlan
    from slipscale.stimuli.surface import Stimulus

# Types of steps at which a person can drop out.
PERFORMED = (Instruct, Rest, Feedback, Explore, Ask, Adjust, EndBlock)


class BareStep(NamedTuple):
    """A step, its answer and its duration, without any time for the plate to respond."""

    step: Step
    answer: Answer
    duration_s: float


def bare_run(plan: RunPlan, population: Population | None = None) -> Iterator[BareStep]:
    """Yield the steps of a run with their answers, until the run ends or the person gives up.

    Parameters
    ----------
    plan : RunPlan
    population : Population, optional
        Replaces the default population.
    """
    person = respondent_of(plan, population)
    run = _Bare(person)
    steps = plan.steps()
    try:
        step = next(steps)
        while not (person.gives_up and isinstance(step, PERFORMED)):
            person.memory.now = step
            answer = run.answers[type(step)](step)
            taken = person.read(step.screen) if isinstance(step, EndBlock) else answer
            duration_s = taken.response_time_s if isinstance(taken, Reply) else None
            played = step.played if isinstance(step, Ask) else None
            heard_s = played.sound.duration_s if played else 0.0
            yield BareStep(step, answer, (duration_s or 0.0) + heard_s)
            person.memory.over(step, answer)
            step = steps.send(answer)
    except StopIteration:
        return


def drops_out(plan: RunPlan, population: Population | None = None) -> bool:
    """Return whether the simulated participant gives up during any of their runs."""
    return respondent_of(plan, population).drops_out


class _Bare:
    """State of the plate and the finger, and functions that answer each type of step."""

    def __init__(self, person: Respondent) -> None:
        self.person = person
        self.on_plate: Stimulus | None = None
        self.answers: Mapping[type, Callable[[Any], Answer]] = {
            Instruct: person.read,
            Rest: person.read,
            Explore: self.explore,
            Feedback: person.read,
            Ask: person.answer,
            Adjust: self.adjust,
            Present: self.present,
            Silence: self.silence,
            EndTrial: lambda _: Voided(),
            EndBlock: lambda _: Voided(),
        }

    def present(self, step: Present) -> Presented:
        if step.lead_in and step.lead_in[0].surface != self.on_plate:
            before, explore = step.lead_in
            self.person.memory.begin(explore)
            self.person.memory.feels(explore, _felt_level(before.surface))
        self.on_plate = step.surface
        settled_level = step.surface.settled_level
        return Presented(
            commanded_level=settled_level,
            readback_level=settled_level,
            readback_kind="simulated",
            settled_by="simulated",
            onset_s=0.0,
        )

    def explore(self, step: Explore) -> Reply:
        duration_s = self.person.exploration_s(step)
        self.person.memory.feels(step, _felt_level(self.on_plate))
        return Reply(response_time_s=duration_s)

    def adjust(self, step: Adjust) -> Adjusted:
        clock = VirtualClock()
        start = self.on_plate
        trace = [(0.0, start.level if start else 0.0)]

        def turn(notches: int) -> None:
            aim_level = step.turned_level(trace[-1][1], notches)
            if aim_level != trace[-1][1]:
                trace.append((clock.now(), aim_level))

        def turned(left: Adjust) -> Reply:
            return turned_until_content(
                self.person,
                left,
                lambda: _felt(trace[-1][1], start),
                turn,
                clock,
                again=len(again_s),
            )

        again_s: list[float] = []
        left, reply = step, turned(step)
        while step.again is not None and reply.value == FEEL_AGAIN:
            again_s.append(clock.now())
            reference, explore = step.again
            clock.sleep(self.person.exploration_s(explore))
            self.person.memory.feels(explore, _felt_level(reference.surface))
            left = left.with_less_time(reply.response_time_s or 0.0)
            reply = turned(left)
        return Adjusted(
            value=trace[-1][1],
            response_time_s=None if reply.timed_out else clock.now(),
            time_source=reply.time_source,
            timed_out=reply.timed_out,
            readback_level=trace[-1][1],
            trace=tuple(trace),
            again_s=tuple(again_s),
        )

    def silence(self, _step: Silence) -> None:
        self.on_plate = None


def _felt_level(surface: Stimulus | None) -> float:
    if surface is None:
        return 0.0
    varied = isinstance(surface, Varied)
    return _felt(surface.level if varied else surface.settled_level, surface)


def _felt(level: float, surface: Stimulus | None) -> float:
    """Return the felt level. Amplitudes are rounded as in a session, to `FELT_DIGITS` decimals."""
    return level if isinstance(surface, Varied) else round(level, FELT_DIGITS)
