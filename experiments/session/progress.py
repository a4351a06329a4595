"""Track the session's progress and report it in the operator's status."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from slipscale.experiments.session.operator import Operator, SessionStatus, State
from slipscale.experiments.steps.steps import Ask, EndBlock, EndTrial, Present, Step

if TYPE_CHECKING:
    from slipscale.experiments.session.sound.masking_noise import Noise
    from slipscale.experiments.session.surface_state import SurfaceState
    from slipscale.experiments.steps.trial import Trial
    from slipscale.hardware.clock import Clock
    from slipscale.hardware.errors import PlateFault


class Progress:
    """Counts trials, faults and voided trials, and updates the operator's status.

    Parameters
    ----------
    operator : Operator
    clock : Clock
    noise, surface
        The session's masking noise and surface, whose states are shown in the status.
    status : SessionStatus
        The status when the session begins or is resumed: planned and voided trials, warnings, and
        whether the operator sees the amplitude. All voided trials are repeated.
    """

    def __init__(
        self,
        operator: Operator,
        clock: Clock,
        *,
        noise: Noise,
        surface: SurfaceState,
        status: SessionStatus,
    ) -> None:
        self._operator = operator
        self._clock = clock
        self._noise = noise
        self._surface = surface
        self._status = status
        self._begun_s = clock.now()
        self._away_s = 0.0  # duration of faults and pauses
        self._done_before = 0
        self._trial: Trial | None = None  # the last trial whose surface was presented
        self._over = False
        self._before: Trial | None = None  # the last finished trial, while another is in progress
        self._closing = False  # whether the last finished trial can still be repeated
        self._fault: PlateFault | None = None

    @property
    def voidable(self) -> Trial | None:
        """The trial that can be voided now (the current or the last trial), or None."""
        trial = self._trial
        ended = trial and self._over and trial.number >= trial.total and not self._closing
        return None if ended else trial

    @property
    def answered(self) -> Trial | None:
        """The trial before the current trial if it can still be repeated; otherwise None."""
        before, now = self._before, self.voidable
        return before if before and now and before.task == now.task else None

    @property
    def unblinded(self) -> bool:
        """Whether the operator sees amplitudes."""
        return self._status.unblinded

    def unblind(self) -> None:
        """Show the operator the amplitude from now on."""
        self._status = replace(self._status, unblinded=True)
        self.tell(self._status.state, level=self._surface.level)

    @property
    def asked(self) -> tuple[Ask, ...]:
        """The questions asked so far that can be repeated."""
        return self._status.asked

    def was_asked(self, question: Ask) -> bool:
        """Return whether a question was asked and can be repeated."""
        return question in self._status.asked

    def before(self, question: Ask) -> Ask | None:
        """Return the previous question if the participant can go back to it, otherwise None."""
        asked = self.asked
        place = asked.index(question) if question in asked else len(asked)
        if not _is_lasting(question) or place == 0 or asked[place - 1].by != "participant":
            return None
        return asked[place - 1]

    @contextmanager
    def away(self) -> Iterator[None]:
        """Exclude the time spent in this context (a fault or a pause) from the elapsed time."""
        began_s = self._clock.now()
        try:
            yield
        finally:
            self._away_s += self._clock.now() - began_s

    def replayed(self) -> None:
        """Mark the end of the replay of earlier trials; the pace is measured from this point."""
        self._done_before = self._status.done

    def begins(self, step: Step) -> None:
        """Register the trial to which a step belongs."""
        self._closing = isinstance(step, EndBlock)
        if step.trial:
            self._status = replace(
                self._status,
                task=step.trial.task,
                trial=step.trial.number,
                total=step.trial.total,
            )

    def ends(self, step: Step) -> None:
        """Update the trial counts and the current trial at the end of a step."""
        self.begins(step)
        self._closing = False
        if isinstance(step, Ask) and _is_lasting(step) and not self.was_asked(step):
            self._status = replace(self._status, asked=(*self._status.asked, step))
        elif isinstance(step, Present) and step.trial:
            self._before = self._trial if self._over else None
            self._trial, self._over = step.trial, False
        elif isinstance(step, EndTrial):
            self._trial, self._over, self._before = step.trial, True, None
            self._status = replace(self._status, done=self._status.done + 1)

    def fault(self) -> None:
        """Count a fault."""
        self._status = replace(self._status, faults=self._status.faults + 1)

    def void(self) -> None:
        """Count a voided trial, which will be repeated."""
        status = self._status
        self._status = replace(status, voided=status.voided + 1, planned=status.planned + 1)

    def asks_operator(self, question: Ask | None) -> None:
        """Show the operator a question to answer; None removes the question."""
        self._status = replace(self._status, answering=question)
        self._operator.tell(self._status)

    def warn(self, warning: str) -> None:
        """Add a warning to the operator's status, where it remains visible."""
        self._status = replace(self._status, warnings=(*self._status.warnings, warning))
        self.say(warning)

    def say(self, message: str) -> None:
        """Show the operator a message without changing the session's state."""
        self.tell(self._status.state, message=message)

    def visible(self, fault: PlateFault) -> PlateFault:
        """Return a fault as the operator may see it: without amplitudes unless unblinded."""
        return fault if self.unblinded else fault.blinded()

    def tell(
        self,
        state: State,
        *,
        message: str = "",
        fault: PlateFault | None = None,
        level: float | None = None,
    ) -> None:
        """Update the status shown to the operator, with the amplitude only if unblinded."""
        # A fault remains visible, also next to a message, until the session continues.
        self._fault = (fault or self._fault) if state == "fault" else None
        told = [message, *([str(self.visible(self._fault))] if self._fault else [])]
        elapsed_s = self._clock.now() - self._begun_s - self._away_s
        done = self._status.done - self._done_before
        left = max(self._status.planned - self._status.done, 0)
        self._status = replace(
            self._status,
            state=state,
            message=". ".join(filter(None, told)),
            code=self._fault.code if self._fault else "",
            voidable=self.voidable,
            answered=self.answered,
            noise=self._noise.state,
            plate=self._surface.state,
            temperature_c=self._surface.temperature_c,
            elapsed_s=elapsed_s,
            time_left_s=elapsed_s / done * left if done else None,
            level=self._surface.quantity.short(level)
            if self.unblinded and level is not None
            else None,
        )
        self._operator.tell(self._status)


def _is_lasting(step: Ask) -> bool:
    """Return whether a question can be repeated later.

    Questions within a trial, questions with a sound, and operator decisions cannot be repeated.
    """
    decision = step.by == "operator" and bool(step.question.listed)
    return not (step.trial or step.played or decision)
