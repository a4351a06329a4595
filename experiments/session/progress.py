"""How far a session has come: the counts that the operator's status is made of."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from experiments.protocols.steps import EndBlock, EndTrial, Present
from experiments.session.operator import SessionStatus

if TYPE_CHECKING:
    from experiments.protocols.steps import Step, Trial
    from experiments.session.operator import Operator, State
    from hardware.clock import Clock


class Progress:
    """Counts trials, faults and voids, and tells the operator.

    Parameters
    ----------
    operator : Operator
    clock : Clock
    planned : int
        How many trials the whole session is expected to have.
    voided : int
        How many trials were voided before the session was resumed; each is repeated.
    """

    def __init__(self, operator: Operator, clock: Clock, planned: int, voided: int = 0) -> None:
        self._operator = operator
        self._clock = clock
        self._status = SessionStatus(state="showing", planned=planned + voided, voided=voided)
        self._begun_s = clock.now()
        self._done_before = 0
        self._trial: Trial | None = None  # the last whose surface was presented
        self._over = False
        self._closing = False  # the protocol can still repeat a trial that is over

    @property
    def voidable(self) -> Trial | None:
        """The trial that can be voided now: the one in progress, or the last, or none."""
        trial = self._trial
        ended = trial and self._over and trial.number >= trial.total and not self._closing
        return None if ended else trial

    def replayed(self) -> None:
        """Note that what follows is live: the pace is reckoned from here."""
        self._done_before = self._status.done

    def begins(self, step: Step) -> None:
        """Note the trial that a step belongs to."""
        self._closing = isinstance(step, EndBlock)
        if step.trial:
            self._status = replace(
                self._status,
                task=step.trial.task,
                trial=step.trial.number,
                total=step.trial.total,
            )

    def ends(self, step: Step) -> None:
        """Note what is over with a step."""
        self.begins(step)
        self._closing = False
        if isinstance(step, Present) and step.trial:
            self._trial, self._over = step.trial, False
        elif isinstance(step, EndTrial):
            self._trial, self._over = step.trial, True
            self._status = replace(self._status, done=self._status.done + 1)

    def fault(self) -> None:
        """Count a fault."""
        self._status = replace(self._status, faults=self._status.faults + 1)

    def void(self) -> None:
        """Count a voided trial, which will be repeated."""
        status = self._status
        self._status = replace(status, voided=status.voided + 1, planned=status.planned + 1)

    def say(self, message: str) -> None:
        """Tell the operator something; the state stays as it is."""
        self.tell(self._status.state, message=message)

    def tell(
        self, state: State, *, message: str = "", amplitude_um_pp: float | None = None
    ) -> None:
        """Tell the operator the state."""
        elapsed_s = self._clock.now() - self._begun_s
        done = self._status.done - self._done_before
        left = max(self._status.planned - self._status.done, 0)
        self._status = replace(
            self._status,
            state=state,
            message=message,
            voidable=self.voidable,
            elapsed_s=elapsed_s,
            time_left_s=elapsed_s / done * left if done else None,
            amplitude_um_pp=amplitude_um_pp,
        )
        self._operator.tell(self._status)
