"""Ask the participant or the operator questions, and repeat earlier questions on request.

The answer to a repeated question is recorded and replaces the old answer in the data. The new
answer is not passed to the protocol, so the steps already carried out remain valid. No shipped
protocol bases decisions on these answers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from slipscale.experiments.journal.serialisation import answer_record, step_record
from slipscale.experiments.participants.base import StopRequested, Unfinished, Watch
from slipscale.experiments.session.markers import Event
from slipscale.experiments.steps.questions.base import CONSENT
from slipscale.experiments.steps.replies import BACK, NO_SOUND, Reply
from slipscale.experiments.steps.steps import Ask, Feedback, Played
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.experiments.journal.record import Record
    from slipscale.experiments.session.interruptions import Interruptions
    from slipscale.experiments.session.measured_contact import Contact
    from slipscale.experiments.session.operator_answers import OperatorAnswers
    from slipscale.experiments.session.parts import Parts
    from slipscale.experiments.session.sound.question_sounds import Sounds


@dataclass(frozen=True, slots=True, kw_only=True)
class Asking:
    """Carries out `Ask` steps.

    Parameters
    ----------
    parts : Parts
        Components that the session's actions share.
    sounds, contact, interruptions, operator_answers
        Further components of the session.
    wait : callable
        Shows the operator that the session is waiting for the participant.
    """

    parts: Parts
    sounds: Sounds
    contact: Contact
    interruptions: Interruptions
    operator_answers: OperatorAnswers
    wait: Callable[[], None]

    def answer(self, step: Ask) -> Reply:
        """Obtain the answer to a question; the participant may first return to earlier questions.

        An earlier question is repeated as if the operator had requested the repetition. The journal
        contains both answers. If the session is killed before the second answer, the resumed run
        repeats the question.
        """
        before = self.parts.progress.before(step) if step.by == "participant" else None
        while True:
            reply = self._answer_once(replace(step, back=before is not None))
            if before is None or reply.value != BACK:
                return reply
            self.parts.journal.write("ask_again", what=step_record(before))
            self._again(before)

    def repeat_requested(self) -> None:
        """Repeat the questions selected by the operator."""
        for question in self.interruptions.take_questions():
            self._again(question)

    def _again(self, question: Ask) -> None:
        """Repeat a question; the new answer replaces the old one."""
        reply = self.interruptions.attempt(partial(self._ask_apart, question))
        self.parts.journal.write(
            "answered_again", what=step_record(question), answer=answer_record(reply)
        )
        if question.name == CONSENT and isinstance(reply, Reply) and reply.value == "no":
            raise StopRequested("the participant withdrew consent")

    def _ask_apart(self, question: Ask) -> Reply:
        """Ask a question while the plate is silent. The current surface is lost."""
        self.parts.surface.hush()
        self.parts.noise.stop()
        self.wait()
        return self.answer(question)

    def _answer_once(self, step: Ask) -> Reply:
        """Obtain the answer to a question. If interrupted, record what has been entered so far."""
        begun = _last_unfinished(self.parts.journal.records, step)
        self.parts.participant.unfinished = begun
        try:
            with self.contact.measured(step, self.interruptions.watch) as watch:
                if step.played and not self._hear(step, step.played, watch):
                    return Reply(value=NO_SOUND, onset_s=self.parts.clock.now())
                if step.by == "operator":
                    reply = self.operator_answers.await_answer(step, self.parts.participant, watch)
                else:
                    reply = self.parts.participant.perform(step, watch)
        except UserError:
            raise  # usually the journal itself failed, so nothing can be recorded
        except BaseException:
            left = self.parts.participant.unfinished
            if left != begun:
                trial = step.trial.number if step.trial else None
                self.parts.journal.write(
                    "unfinished",
                    name=step.name,
                    trial=trial,
                    entry=left.entry,
                    rejected=left.rejected,
                )
            raise
        self.parts.markers.mark(Event.ANSWER, step)
        return reply

    def _hear(self, step: Ask, played: Played, watch: Watch) -> bool:
        """Play a sound while the participant listens; return whether the sound could be played."""
        if self.sounds.missing:
            self.parts.journal.write(NO_SOUND, name=step.name, reason=self.sounds.missing)
            self.parts.progress.warn(f"no headphone test: {self.sounds.missing}")
            return False
        self.sounds.start(played.sound)
        try:
            listening = Feedback(text=played.text, duration_s=played.sound.duration_s)
            self.parts.participant.perform(listening, watch)
        finally:
            self.sounds.stop()
        return True


def _last_unfinished(records: list[Record], step: Ask) -> Unfinished:
    """Return the entry that was unfinished when an answer was interrupted, from the journal."""
    trial = step.trial.number if step.trial else None
    for record in reversed(records):
        if record.kind in ("done", "answered_again"):
            break
        data = record.data
        if record.kind == "unfinished" and (data["name"], data["trial"]) == (step.name, trial):
            return Unfinished(entry=data["entry"], rejected=tuple(data["rejected"]))
    return Unfinished()
