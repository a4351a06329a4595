"""A simulated participant in a session, who feels the plate's actual vibration."""

from __future__ import annotations

import math
from collections.abc import Callable
from statistics import fmean
from typing import TYPE_CHECKING, ClassVar, Self

from slipscale.experiments.participants.base import Kind, StopRequested, Turn, Unfinished, Watch
from slipscale.experiments.participants.simulated_people.finger import SimulatedFinger
from slipscale.experiments.steps.replies import FEEL_AGAIN, Reply
from slipscale.experiments.steps.steps import (
    Adjust,
    Ask,
    Explore,
    ParticipantStep,
    Present,
    Step,
    Steps,
)
from slipscale.stimuli.varied import Varied

if TYPE_CHECKING:
    from slipscale.experiments.participants.simulated_people.respondent import Respondent
    from slipscale.hardware.clock import Clock
    from slipscale.stimuli.surface import Stimulus

# The plate's readback varies by a fraction of a micrometre. A finger cannot distinguish 2.298 from
# 2.302 µm, and answers must not depend on the last digit.
FELT_DIGITS = 2
# Number of points of the stroke at which a surface is felt; the mean is rated. Only textures differ
# between these points.
TOUCHES = 32
TURN_S = 0.6  # time per notch for turning, feeling and deciding
# Ends an endless adjustment. No adjustment range has this many notches.
MOST_TURNS = 1000
GAVE_UP = "the simulated participant gave up"


class SimulatedParticipant:
    """A simulated person who takes part in a session.

    Parameters
    ----------
    respondent : Respondent
        The person who answers.
    feel : callable
        Returns the plate's actual amplitude in µm peak to peak, which may differ from the commanded
        amplitude.
    clock : Clock
        A virtual clock, so that no real time passes.
    frame_s : float, optional
        Interval between calls to ``watch`` during an exploration. Required if
        sensors record the finger's position or force.
    """

    kind: ClassVar[Kind] = "simulated"
    unfinished = Unfinished()
    cursor_mm: tuple[float, float] | None = None

    def __init__(
        self,
        respondent: Respondent,
        *,
        feel: Callable[[], float],
        clock: Clock,
        frame_s: float | None = None,
    ) -> None:
        self.respondent = respondent
        self._feel = feel
        self._shown: dict[tuple[int | None, int | None], Stimulus] = {}
        self._turned_level = 0.0
        self._clock = clock
        self._frame_s = frame_s
        self.finger = SimulatedFinger(respondent.constant_stream("finger"))

    def attend(self, steps: Steps) -> Steps:
        """Yield a protocol's steps, and update the person's memory after each finished step.

        Replayed steps update the memory too, so it does not depend on whether the run was
        interrupted.
        """
        try:
            step = next(steps)
            while True:
                self.respondent.memory.now = step
                self._see(step)
                answer = yield step
                self.respondent.memory.over(step, answer)
                step = steps.send(answer)
        except StopIteration:
            return

    def _see(self, step: Step) -> None:
        """Store a step's stimuli, because amplitude alone does not identify `Varied` stimuli."""
        if isinstance(step, Present):
            for part in (*(step.lead_in or ())[:1], step):
                self._shown[_place(part)] = part.surface

    def _felt(self, step: Explore | Adjust) -> float | None:
        """Return the level of a step's stimulus if it is a varied stimulus, otherwise None."""
        shown = self._shown.get(_place(step))
        return shown.level if isinstance(shown, Varied) else None

    def perform(self, step: ParticipantStep, watch: Watch) -> Reply:
        """Simulate the person's part of a step: reading, exploring, answering or resting."""
        watch()
        self._stop_if_enough()
        onset_s = self._clock.now()
        if isinstance(step, Explore):
            reply = self._explore(step, watch)
        else:
            reply = (
                self.respondent.answer(step)
                if isinstance(step, Ask)
                else self.respondent.read(step)
            )
            self._clock.sleep(reply.response_time_s or 0.0)
        watch()
        return Reply(
            value=reply.value,
            onset_s=onset_s,
            response_time_s=None if reply.timed_out else reply.response_time_s,
            time_source="simulated",
            timed_out=reply.timed_out,
        )

    def adjust(self, step: Adjust, turn: Turn, watch: Watch, *, again: int = 0) -> Reply:
        """Adjust the surface until the person accepts it or requests the reference."""
        watch()
        self._stop_if_enough()

        felt_level = self._felt(step)
        if felt_level is not None and not again:
            self._turned_level = felt_level

        def watched(notches: int) -> None:
            turn(notches)
            self._turned_level = step.turned_level(self._turned_level, notches)
            watch()

        def feel() -> float:
            return round(self._feel(), FELT_DIGITS) if felt_level is None else self._turned_level

        return turned_until_content(self.respondent, step, feel, watched, self._clock, again=again)

    def hold(self, _text: str, until: Callable[[], bool]) -> None:
        """Wait until ``until()`` is true."""
        while not until():
            self._clock.sleep(0.1)

    def _stop_if_enough(self) -> None:
        if self.respondent.gives_up:
            raise StopRequested(GAVE_UP)

    def _explore(self, step: Explore, watch: Watch) -> Reply:
        """Stroke the surface for a random duration, and store the mean level felt."""
        person = self.respondent
        duration_s = person.exploration_s(step)
        moments = person.stream("touch")
        begun_s = self._clock.now()
        touches = []
        self.finger.strokes(begun_s, person.stream("finger"), step.guide)
        for touch in range(TOUCHES):
            share = (touch + moments.uniform()) / TOUCHES
            self._pass_until(begun_s + share * duration_s, watch)
            touches.append(round(self._feel(), FELT_DIGITS))
        self._pass_until(begun_s + duration_s, watch)
        if self._frame_s:
            watch()  # the last samples, before the finger leaves
        self.finger.lifts()
        felt_level = self._felt(step)
        person.memory.feels(
            step, round(fmean(touches), FELT_DIGITS) if felt_level is None else felt_level
        )
        return Reply(response_time_s=duration_s)

    def _pass_until(self, time_s: float, watch: Watch) -> None:
        """Advance the clock; if sensors record the finger, call ``watch`` once per frame."""
        while self._frame_s and self._clock.now() + self._frame_s < time_s:
            self._clock.sleep(self._frame_s)
            watch()
        self._clock.sleep(time_s - self._clock.now())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        return None


def _place(step: Present | Explore | Adjust) -> tuple[int | None, int | None]:
    return step.trial.number if step.trial else None, step.interval


def turned_until_content(
    person: Respondent,
    step: Adjust,
    feel: Callable[[], float],
    turn: Turn,
    clock: Clock,
    *,
    again: int = 0,
) -> Reply:
    """Adjust the surface notch by notch until the person accepts the surface.

    Parameters
    ----------
    feel : callable
        Returns the level that the person currently feels, in the study's quantity.
    again : int
        Number of times that the reference was repeated. A value above 0 means that this call
        continues an earlier adjustment.
    """
    onset_s = clock.now()
    limit_s = math.inf if step.time_limit_s is None else step.time_limit_s
    person.memory.begin(step)
    person.memory.turned, person.memory.felt_again = person.memory.turned if again else 0, again
    timed_out, value = False, None
    for _ in range(MOST_TURNS):
        clock.sleep(TURN_S)
        if clock.now() - onset_s > limit_s:
            timed_out = True
            break
        person.memory.feels(step, feel())
        told = person.told(step)
        if told == FEEL_AGAIN:
            value = FEEL_AGAIN
            break
        notches = int(told or 0)
        if not notches:
            break
        turn(notches)
        person.memory.turned += notches
    return Reply(
        value=value,
        onset_s=onset_s,
        response_time_s=None if timed_out else clock.now() - onset_s,
        time_source="simulated",
        timed_out=timed_out,
    )
