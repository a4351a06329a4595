"""A scripted participant, who gives a list of answers in order."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, ClassVar, Self

from slipscale.experiments.participants.base import Kind, Turn, Unfinished, Watch
from slipscale.experiments.steps.replies import FEEL_AGAIN, Reply
from slipscale.experiments.steps.steps import Adjust, Ask, ParticipantStep

if TYPE_CHECKING:
    from slipscale.experiments.steps.trial import Value
    from slipscale.hardware.clock import Clock


class ScriptedParticipant:
    """Answers questions from a list, or with a function of the question.

    Parameters
    ----------
    script : iterable or callable
        The answers, or a function that returns the answer to an `Ask`. A `Reply` is returned
        unchanged; an exception given as an answer is raised. The answer to an `Adjust` is the
        number of notches, or `FEEL_AGAIN`.
    clock : Clock
        Advances by ``step_s`` in each step.
    step_s : float
        Seconds.
    """

    kind: ClassVar[Kind] = "scripted"
    unfinished = Unfinished()
    cursor_mm: tuple[float, float] | None = None
    finger = None

    def __init__(
        self,
        script: Iterable[Value | Reply | BaseException] | Callable[[Ask | Adjust], Value],
        clock: Clock,
        step_s: float = 1.0,
    ) -> None:
        self._answers = None if callable(script) else iter(script)
        self._give = script if callable(script) else None
        self._clock = clock
        self._step_s = step_s
        self.seen: list[ParticipantStep] = []
        self.turned: list[Adjust] = []

    def perform(self, step: ParticipantStep, watch: Watch) -> Reply:
        """Let ``step_s`` pass, then give the next answer."""
        watch()
        self.seen.append(step)
        onset_s = self._clock.now()
        self._clock.sleep(self._step_s)
        answer = self._next(step) if isinstance(step, Ask) else None
        watch()
        if isinstance(answer, BaseException):
            raise answer
        if isinstance(answer, Reply):
            return answer
        return Reply(value=answer, onset_s=onset_s, response_time_s=self._step_s)

    def _next(self, step: Ask) -> Value | Reply | BaseException:
        return self._give(step) if self._give else next(self._answers or iter(()))

    def adjust(
        self,
        step: Adjust,
        turn: Turn,
        watch: Watch,
        *,
        again: int = 0,  # noqa: ARG002 - fixed by the script
    ) -> Reply:
        """Adjust the surface by the next answer, notch by notch, or request the reference."""
        watch()
        self.turned.append(step)
        onset_s = self._clock.now()
        answer = self._give(step) if self._give else next(self._answers or iter(()))
        if answer == FEEL_AGAIN:
            return Reply(value=FEEL_AGAIN, onset_s=onset_s, response_time_s=0.0)
        notches = int(str(answer))
        for _ in range(abs(notches)):
            self._clock.sleep(self._step_s)
            turn(1 if notches > 0 else -1)
            watch()
        return Reply(onset_s=onset_s, response_time_s=self._clock.now() - onset_s)

    def hold(self, _text: str, until: Callable[[], bool]) -> None:
        """Wait until ``until()`` is true."""
        while not until():
            self._clock.sleep(0.1)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        return None
