"""Handle interruptions of a session's steps: operator requests and rig faults.

This module is independent of the protocol and its steps. An interrupted action is restarted after
the pause ends or the fault is cleared.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from slipscale.experiments.journal.serialisation import same_step, step_record
from slipscale.experiments.participants.base import StopRequested
from slipscale.experiments.session.markers import Event
from slipscale.experiments.steps.replies import Answer, Voided
from slipscale.faults.message import Message
from slipscale.hardware.errors import PlateFault, StillVibrating
from slipscale.hardware.signals import raise_if_ended

if TYPE_CHECKING:
    from slipscale.experiments.journal.record import Record
    from slipscale.experiments.session.operator import Operator, Request, State
    from slipscale.experiments.session.operator_answers import OperatorAnswers
    from slipscale.experiments.session.parts import Parts
    from slipscale.experiments.steps.steps import Ask
    from slipscale.experiments.steps.trial import Trial
    from slipscale.hardware.driver import PlateDriver

RECONNECT_WAIT_S = 0.5
UNBLINDED = "unblinded: the operator sees the amplitude from now on"


class _Paused(Exception):
    """Raised when the operator requests a pause during a step."""


def stop_of(request: Request) -> StopRequested:
    """Return the exception that ends the session, with the operator's reason, if any."""
    reason = f": {request.reason}" if request.reason else ""
    return StopRequested(Message("requested by the operator{reason}", reason=reason))


class Interruptions:
    """Monitors the operator and the rig while a session's steps are carried out.

    Parameters
    ----------
    parts : Parts
        Components that the session's actions share.
    plate, operator, answers
        Further components of the session.
    hold_text : str
        Text that asks the participant to wait.
    """

    def __init__(
        self,
        *,
        parts: Parts,
        plate: PlateDriver,
        operator: Operator,
        answers: OperatorAnswers,
        hold_text: str,
    ) -> None:
        self._parts = parts
        self._plate = plate
        self._operator = operator
        self._answers = answers
        self._hold_text = hold_text
        self._voids = _pending_voids(parts.journal.records)
        self._questions = _pending_questions(parts.journal.records)

    def attempt(self, action: Callable[[], Answer]) -> Answer:
        """Carry out an action, and repeat it until it ends without a fault or a pause."""
        paused = False
        while True:
            try:
                if paused:
                    self._hold()
                    paused = False
                return action()
            except PlateFault as fault:
                with self._parts.progress.away():
                    self._recover(fault)
            except _Paused:
                paused = True

    def watch(self) -> None:
        """Check the plate, the disk and the operator in each frame of a step."""
        self._parts.surface.check()
        self._parts.journal.check()
        self.watch_operator()

    def watch_operator(self) -> None:
        """Carry out the operator's next request, if any."""
        request = self._poll()
        if request is None:
            return
        if request.what == "void":
            self._void(request)
        elif request.what == "ask_again":
            self._ask_again(request)
        elif request.what == "note":
            self._note(request)
        elif request.what == "unblind":
            self._unblind()
        elif request.what == "answer":
            self._answers.take(request.reason)
        elif request.what == "pause":
            raise _Paused
        elif request.what == "stop":
            raise stop_of(request)

    def _poll(self) -> Request | None:
        """Return the operator's next request, if any; raise if a signal was received."""
        raise_if_ended()
        return self._operator.poll()

    def take_voids(self) -> Voided:
        """Return the trials voided since the last call, and clear the list."""
        voided, self._voids = self._voids, Voided()
        return voided

    def take_questions(self) -> list[Ask]:
        """Return the questions to repeat, and clear the list."""
        wanted, self._questions = self._questions, []
        return [
            asked
            for what in wanted
            for asked in self._parts.progress.asked
            if same_step(what, step_record(asked))
        ]

    def await_reason(self) -> None:
        """Keep the participant waiting while the operator types the reason for voiding a trial."""

        def typed() -> bool:
            self.watch_operator()
            return not self._operator.busy

        if not typed():
            self._parts.participant.hold(self._hold_text, typed)

    def _void(self, request: Request) -> None:
        """Void the current trial, or an earlier trial that the protocol can still repeat."""
        now = self._parts.progress.voidable
        trial = request.trial or now
        if trial is None:
            self._parts.progress.say("no trial can be voided now")
        elif now is None or trial.task != now.task:
            self._parts.progress.say(
                Message(
                    "trial {trial_number} cannot be repeated, because its part of the run is over",
                    trial_number=trial.number,
                )
            )
        elif (trial.task, trial.number) in self._voided():
            self._parts.progress.say(
                Message("trial {trial_number} is already voided", trial_number=trial.number)
            )
        else:
            self.reject(trial, request.reason, repeated=True)

    def reject(self, trial: Trial, reason: str, *, repeated: bool) -> None:
        """Void a trial unless it is already voided.

        If ``repeated`` is True, the protocol will repeat the trial.
        """
        if (trial.task, trial.number) in self._voided():
            return
        void = {"task": trial.task, "trial": trial.number, "reason": reason}
        self._parts.journal.write("void", **void, **({} if repeated else {"repeated": False}))
        self._voids = _with(self._voids, trial.number, repeated=repeated)
        if repeated:
            self._parts.progress.void()
            self._parts.progress.say(
                Message("trial {trial_number} will be repeated", trial_number=trial.number)
            )
        else:
            self._parts.progress.say(
                Message(
                    "trial {trial_number} was rejected ({reason})",
                    trial_number=trial.number,
                    reason=reason,
                )
            )

    def _ask_again(self, request: Request) -> None:
        """Register a question about the run or the participant that will be asked again."""
        question = request.question
        if question is None or not self._parts.progress.was_asked(question):
            self._parts.progress.say("this question cannot be asked again")
        elif (what := step_record(question)) not in self._questions:
            self._parts.journal.write("ask_again", what=what)
            self._questions.append(what)
            self._parts.progress.say(
                Message(
                    "'{question_name}' will be asked again after the trial",
                    question_name=question.name,
                )
            )

    def _note(self, request: Request) -> None:
        """Write the operator's note to the journal."""
        self._parts.journal.write("note", text=request.reason)
        self._parts.progress.say("the note was saved in the journal")

    def _unblind(self) -> None:
        """Unblind the operator: show the amplitude from now on, and record this."""
        if not self._parts.progress.unblinded:
            self._parts.journal.write("note", text=UNBLINDED)
            self._parts.progress.unblind()

    def _voided(self) -> list[tuple[str, int]]:
        """Return all trials voided in this run, as (task, number) pairs."""
        voids = [record.data for record in self._parts.journal.records if record.kind == "void"]
        return [(void["task"], void["trial"]) for void in voids]

    def _hold(self) -> None:
        """Pause the session: silence the plate and wait until the operator resumes."""
        with self._parts.progress.away():
            self._parts.surface.hush()
            self._parts.markers.mark(Event.PAUSE)
            self._parts.journal.write("pause")
            self._wait_for("paused", "go_on")
            self._parts.journal.write("go_on")

    def _recover(self, fault: PlateFault) -> None:
        """Silence the plate, record the fault, wait for the operator's decision, and reconnect.

        That the plate may still vibrate is shown until it is connected again, in place of any other
        fault.
        """
        still = self._parts.surface.shut_down()
        while True:
            self._parts.markers.mark(Event.FAULT)
            self._parts.progress.fault()
            self._parts.journal.write("fault", **fault.record())
            if still and not isinstance(fault, StillVibrating):
                self._parts.journal.write("fault", **still.record())
            still = self._parts.surface.disconnect() or still
            self._parts.clock.sleep(RECONNECT_WAIT_S)
            urgent = still or fault
            try:
                self._wait_for("fault", "retry", urgent)
            except StopRequested as stopped:
                self._parts.journal.write("given_up", reason=str(stopped))
                raise self._parts.progress.visible(urgent) from None
            try:
                self._plate.connect()
            except PlateFault as again:
                fault = again
            else:
                self._parts.journal.write("retry")
                return

    def _wait_for(self, state: State, wanted: str, fault: PlateFault | None = None) -> None:
        """Wait until the operator makes the request ``wanted`` or stops the session."""
        self._parts.noise.stop()
        self._parts.progress.tell(state, fault=fault)

        def answered() -> bool:
            request = self._poll()
            if request is not None and request.what == "stop":
                raise stop_of(request)
            if request is not None and request.what == "void":
                self._void(request)
            if request is not None and request.what == "ask_again":
                self._ask_again(request)
            if request is not None and request.what == "note":
                self._note(request)
            if request is not None and request.what == "unblind":
                self._unblind()
            return request is not None and request.what == wanted

        if not answered():
            self._parts.participant.hold(self._hold_text, answered)


def _pending_questions(records: list[Record]) -> list[dict[str, object]]:
    """Return the step records of the questions that remain to be repeated."""
    waiting: list[dict[str, object]] = []
    for record in records:
        if record.kind == "ask_again":
            waiting.append(record.data["what"])
        elif record.kind == "answered_again":
            waiting = [what for what in waiting if not same_step(what, record.data["what"])]
    return waiting


def _with(voided: Voided, trial: int, *, repeated: bool) -> Voided:
    if repeated:
        return replace(voided, trials=(*voided.trials, trial))
    return replace(voided, dropped=(*voided.dropped, trial))


def _pending_voids(records: list[Record]) -> Voided:
    """Return the voided trials that have not been passed to the protocol yet."""
    waiting = Voided()
    for record in records:
        if record.kind == "void":
            repeated = record.data.get("repeated", True)
            waiting = _with(waiting, record.data["trial"], repeated=repeated)
        elif record.kind == "done" and (record.data["answer"] or {}).get("type") == "Voided":
            waiting = Voided()
    return waiting
