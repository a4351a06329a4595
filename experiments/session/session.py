"""The session loop, which carries out a protocol's steps.

A step is complete when its answer is in the journal; only then is the answer passed to the
protocol. The next question is asked only after the previous answer is on disk. A crash therefore
loses at most the step in progress, and a power cut at most the last answer. In a resumed run, the
loop takes the answers given so far from the journal. Records are flushed to disk while surfaces are
being presented and explored.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Literal

from slipscale.experiments.journal.serialisation import answer_record, step_record
from slipscale.experiments.participants.base import StopRequested
from slipscale.experiments.session.actions.adjusting import Adjusting
from slipscale.experiments.session.actions.asking import Asking
from slipscale.experiments.session.actions.presenting import Presenting
from slipscale.experiments.session.followed_textures import Following
from slipscale.experiments.session.interruptions import Interruptions
from slipscale.experiments.session.markers import Event
from slipscale.experiments.session.measured_contact import Contact
from slipscale.experiments.session.operator import SessionStatus
from slipscale.experiments.session.operator_answers import OperatorAnswers
from slipscale.experiments.session.parts import Parts, Setup
from slipscale.experiments.session.passive_exploration import moved, stage_of
from slipscale.experiments.session.progress import Progress
from slipscale.experiments.session.replay import finished, replay
from slipscale.experiments.session.stroke_control import StrokeControl
from slipscale.experiments.session.surface_state import SurfaceState
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
    Steps,
)
from slipscale.faults import UserError
from slipscale.hardware.errors import PlateFault

if TYPE_CHECKING:
    from slipscale.experiments.languages.texts import Texts
    from slipscale.experiments.steps.replies import Adjusted, Answer, Reply, Voided
    from slipscale.experiments.study.stroke import Stroke
    from slipscale.hardware.contact.source import ContactSource, Kind, Sample

RunOutcome = Literal["complete", "stopped"]
# These steps do not wait until the last answer is on disk.
WHILE_THE_DISK_WORKS = (Present, Explore, Silence, Feedback, EndTrial)


class Session:
    """One run of a protocol in the laboratory or in a pilot.

    Parameters
    ----------
    steps : generator
        The protocol's steps.
    setup : Setup
        All objects with which the session interacts.
    texts : Mapping
        Wording of the screen that asks the participant to wait.
    planned : int
        Expected number of trials in the whole session.
    sources : Mapping, optional
        Connected finger-position and force sources, whose samples are recorded. If the position is
        measured, textures follow the finger on plates that support this.
    stroke : Stroke, optional
        Stroke windows; a trial with strokes outside the windows may be rejected.
    """

    def __init__(
        self,
        *,
        steps: Steps,
        setup: Setup,
        texts: Texts,
        planned: int = 0,
        sources: Mapping[Kind, ContactSource] | None = None,
        stroke: Stroke | None = None,
    ) -> None:
        plate, participant, journal, clock = (
            setup.plate,
            setup.participant,
            setup.journal,
            setup.clock,
        )
        self._steps = steps
        self._participant = participant
        self._journal = journal
        self._noise = setup.noise
        self._markers = setup.markers
        self._markers.lost = self._marker_lost
        following = Following(plate, clock, sources or {})
        self._surface = SurfaceState(plate, clock, self._feel, following)
        self._contact = Contact(sources or {}, journal, self._moved)
        self._stage = stage_of(stroke, sources or {})
        # If the window measures the position, it already shows its pointer.
        position = (sources or {}).get("position")
        self._shows_finger = position is not None and position.name != "mouse"
        self._stroke = StrokeControl(stroke, journal, texts) if stroke else None
        voided = sum(
            record.kind == "void" and record.data.get("repeated", True)
            for record in journal.records
        )
        self._progress = Progress(
            setup.operator,
            clock,
            noise=self._noise,
            surface=self._surface,
            status=SessionStatus(
                state="showing",
                planned=planned + voided,
                voided=voided,
                unblinded=setup.unblind,
                warnings=setup.warnings,
            ),
        )
        journal.tell = self._progress.warn
        operator_answers = OperatorAnswers(self._progress, clock)
        parts = Parts(
            surface=self._surface,
            participant=participant,
            journal=journal,
            clock=clock,
            noise=self._noise,
            markers=self._markers,
            progress=self._progress,
        )
        self._interruptions = Interruptions(
            parts=parts,
            plate=plate,
            operator=setup.operator,
            answers=operator_answers,
            hold_text=texts["session.hold"],
        )
        self._presenting = Presenting(parts=parts, tracking=setup.tracking)
        self._asking = Asking(
            parts=parts,
            sounds=setup.sounds,
            contact=self._contact,
            interruptions=self._interruptions,
            operator_answers=operator_answers,
            wait=self._wait,
        )
        self._adjusting = Adjusting(parts=parts, watch=self._interruptions.watch, wait=self._wait)
        self._answered = len(journal.records)  # number of records up to the last answer
        self._actions: Mapping[type, Callable[[Any], Answer]] = {
            Instruct: self._show,
            Rest: self._show,
            Feedback: self._feedback,
            Explore: self._explore,
            Ask: self._ask,
            Adjust: self._adjust,
            Present: self._presenting.present,
            Silence: self._silence,
            EndTrial: self._end_trial,
            EndBlock: self._end_block,
        }

    def run(self) -> RunOutcome:
        """Run until the protocol ends or the session is stopped, and leave the plate silent.

        If the plate could not be switched off, this is recorded, and closing the plate raises
        `StillVibrating`.

        Raises
        ------
        PlateFault
            If the rig failed and the operator stopped the session. The run can be resumed.
        UserError
            If the journal cannot be written or, in a resumed run, does not match the protocol.
        """
        self._markers.mark(Event.BEGIN)
        try:
            self._loop()
            self._shut_down()
            self._journal.write("end")
        except StopRequested as request:
            self._shut_down()
            self._journal.write("stop", reason=str(request) or "requested by the participant")
            return "stopped"
        except UserError:
            self._surface.shut_down()
            raise
        except BaseException as error:
            self._shut_down()
            self._journal.write("stop", reason=f"{type(error).__name__}: {error}")
            raise
        finally:
            self._noise.stop()
            self._markers.mark(Event.END)
        self._progress.tell("done")
        return "complete"

    def _shut_down(self) -> None:
        """Silence the plate, and record if it may still vibrate; closing it raises this fault."""
        if still := self._surface.shut_down():
            self._journal.write("fault", **still.record())

    def _loop(self) -> None:
        """Replay the steps in the journal, and then carry out the remaining steps."""
        past = finished(self._journal.records)
        answer: Answer = None
        number = 0
        while True:
            try:
                step = self._steps.send(answer) if number else next(self._steps)
            except StopIteration:
                # The session was killed between the last step and the repeated question.
                self._asking.repeat_requested()
                return
            if number < len(past):
                answer = replay(step, past[number], self._journal, self._surface)
            else:
                if number == len(past) > 0:
                    self._take_up(step)
                answer = self._live(step, number)
            self._progress.ends(step)
            if isinstance(step, Instruct | EndBlock):
                self._surface.part_over()
            number += 1
            live = number > len(past)
            if live and (step.trial is None or isinstance(step, EndTrial)):
                self._asking.repeat_requested()

    def _take_up(self, step: Step) -> None:
        """Switch from replayed to new steps, and present the interrupted surface again."""
        self._progress.replayed()
        self._presenting.take_up()
        if not isinstance(step, Silence):
            self._interruptions.attempt(lambda: self._presenting.restore(step))

    def _live(self, step: Step, number: int) -> Answer:
        """Carry out a step, repeat it after faults and pauses, and record the answer."""
        answers = not isinstance(step, WHILE_THE_DISK_WORKS)
        if answers:
            self._journal.wait_for(self._answered)
        kept = {"kept": self._answered} if answers else {}
        self._journal.append("begin", step=number, what=step_record(step), **kept)
        self._progress.begins(step)
        answer = self._interruptions.attempt(lambda: self._actions[type(step)](step))
        done = self._journal.append("done", step=number, answer=answer_record(answer))
        if answers:
            self._answered = done.number + 1
        return answer

    def _show(self, step: Instruct | Rest) -> Reply:
        self._noise.stop()
        self._progress.tell("showing")
        return self._participant.perform(step, self._interruptions.watch)

    def _feedback(self, step: Feedback) -> Reply:
        return self._participant.perform(step, self._interruptions.watch)

    def _explore(self, step: Explore) -> Reply:
        self._presenting.restore(step)
        reply = self._feel(step)
        self._surface.confirm()
        self._surface.explored(step)
        if self._stroke and (advice := self._stroke.judged(step, self._contact.last)):
            self._feedback(advice)
        return reply

    def _feel(self, step: Explore) -> Reply:
        self._wait()
        with (
            moved(self._stage, step, self._interruptions.watch) as moving,
            self._contact.measured(step, moving) as watch,
        ):
            return self._participant.perform(step, watch)

    def _ask(self, step: Ask) -> Reply:
        self._presenting.restore(step)
        self._wait()
        reply = self._asking.answer(step)
        try:
            self._surface.confirm()
        except PlateFault:
            # The surface was lost during the answer; this answer is recorded but never used.
            self._journal.write("discarded", name=step.name, answer=answer_record(reply))
            raise
        return reply

    def _adjust(self, step: Adjust) -> Adjusted:
        self._presenting.restore(step)
        self._wait()
        return self._adjusting.adjust(step)

    def _marker_lost(self, name: str, reason: str) -> None:
        """Report and record that a marker output has failed."""
        self._progress.warn(f"NO MORE MARKERS on {name}: {reason}")
        self._journal.write("markers", outputs=list(self._markers.names), lost=name, reason=reason)

    def _silence(self, step: Silence) -> None:
        self._surface.silence(step)

    def _end_trial(self, step: EndTrial) -> Voided:
        self._interruptions.watch_operator()
        if self._stroke and (reason := self._stroke.rejects(step.trial)):
            again = self._stroke.repeats(step.trial)
            self._interruptions.reject(step.trial, reason, repeated=again)
        return self._interruptions.take_voids()

    def _end_block(self, step: EndBlock) -> Voided:
        self._show(step.screen)
        self._interruptions.await_reason()
        return self._interruptions.take_voids()

    def _moved(self, kind: Kind, samples: list[Sample]) -> list[float] | None:
        """Pass samples to the surface, and a measured finger position to the screen.

        Returns the times at which the samples triggered a texture change; see
        `SurfaceState.follow`.
        """
        if kind == "position" and samples and self._shows_finger:
            x_mm, y_mm = samples[-1].values
            self._participant.cursor_mm = x_mm, y_mm
        return self._surface.follow(kind, samples)

    def _wait(self) -> None:
        """Show the operator that the session is waiting for the participant."""
        self._progress.tell("waiting", level=self._surface.level)
