"""The session loop: performs a protocol's steps with a plate, a participant and a journal.

It follows one rule: **a step is over when its answer is in the journal; only then does the
protocol receive the answer. The next question is asked only after that answer is on disk.** A
crash therefore loses at most the step in progress, and a power cut at most the last answer.
Resuming runs the same loop, with the first answers read from the journal. Data are flushed to disk
while surfaces are presented and explored.
"""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from slipscale.experiments.journal.serialisation import (
    answer_from,
    answer_record,
    same_step,
    step_record,
)
from slipscale.experiments.participants.base import StopRequested, Unfinished
from slipscale.experiments.session.adjusting import Adjusting
from slipscale.experiments.session.followed_textures import Following
from slipscale.experiments.session.interruptions import Interruptions
from slipscale.experiments.session.markers import Event, Markers
from slipscale.experiments.session.masking_noise import NoNoise
from slipscale.experiments.session.measured_contact import Contact
from slipscale.experiments.session.operator_answers import OperatorAnswers
from slipscale.experiments.session.progress import Progress
from slipscale.experiments.session.question_sounds import NoSounds
from slipscale.experiments.session.stroke_control import StrokeControl
from slipscale.experiments.session.surface_state import SurfaceState
from slipscale.experiments.steps.questions import CONSENT
from slipscale.experiments.steps.replies import (
    BACK,
    NO_SOUND,
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
)
from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.errors import PlateFault

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from slipscale.experiments.journal.journal import Journal
    from slipscale.experiments.journal.record import Record
    from slipscale.experiments.languages.texts import Texts
    from slipscale.experiments.participants.base import Participant, Watch
    from slipscale.experiments.session.masking_noise import Noise
    from slipscale.experiments.session.operator import Operator
    from slipscale.experiments.session.question_sounds import Sounds
    from slipscale.experiments.session.resonance_tracking import ResonanceTracking
    from slipscale.experiments.steps.steps import Played, Step, Steps
    from slipscale.experiments.study.stroke import Stroke
    from slipscale.hardware.clock import Clock
    from slipscale.hardware.contact.source import ContactSource, Kind, Sample
    from slipscale.hardware.driver import PlateDriver

RunOutcome = Literal["complete", "stopped"]
# After these records, a step restarts from the beginning.
BEGUN_ANEW = ("go_on", "retry")
# These steps do not wait for the last answer to reach the disk.
WHILE_THE_DISK_WORKS = (Present, Explore, Silence, Feedback, EndTrial)


class Past(NamedTuple):
    """A finished step: its first record, the start of the successful attempt, and its answer."""

    begun: Record
    began_s: float
    done: Record


class Session:
    """One run of a protocol's steps.

    Parameters
    ----------
    steps : generator
        The protocol's steps.
    plate, participant, journal, clock, operator
        Everything that a session interacts with. A session with a virtual clock, a mock plate and
        a simulated participant can therefore be replayed byte for byte.
    texts : Mapping
        Texts for the screen that asks the participant to wait.
    planned : int
        Expected number of trials in the whole session.
    noise : Noise, optional
        Masking noise, played from the first surface of a block to the next text or rest.
    sounds : Sounds, optional
        Plays the sounds of the headphone test.
    markers : Markers, optional
        Sends markers to external recorders.
    unblind : bool
        Whether the operator sees the amplitude.
    sources : Mapping, optional
        Connected sources of position and force. Their samples are recorded. If the position is
        measured, textures follow the finger on plates that support it.
    tracking : ResonanceTracking, optional
        Tracks the resonance between trials.
    warnings : tuple of str, optional
        Problems found earlier, to show to the operator.
    stroke : Stroke, optional
        How the participant should stroke; trials outside the windows are rejected.
    """

    def __init__(
        self,
        *,
        steps: Steps,
        plate: PlateDriver,
        participant: Participant,
        journal: Journal,
        clock: Clock,
        operator: Operator,
        texts: Texts,
        planned: int = 0,
        noise: Noise | None = None,
        sounds: Sounds | None = None,
        markers: Markers | None = None,
        unblind: bool = False,
        sources: Mapping[Kind, ContactSource] | None = None,
        tracking: ResonanceTracking | None = None,
        warnings: tuple[str, ...] = (),
        stroke: Stroke | None = None,
    ) -> None:
        self._steps = steps
        self._participant = participant
        self._journal = journal
        self._clock = clock
        self._noise = noise or NoNoise()
        self._sounds = sounds or NoSounds("this session has no sound output")
        self._markers = markers or Markers()
        self._markers.lost = self._marker_lost
        following = Following(plate, clock, sources or {})
        self._surface = SurfaceState(plate, clock, self._feel, following)
        self._tracking = tracking
        self._contact = Contact(sources or {}, journal, self._moved)
        # The window shows its own pointer.
        position = (sources or {}).get("position")
        self._shows_finger = position is not None and position.name != "mouse"
        self._stroke = StrokeControl(stroke, journal, texts) if stroke else None
        voided = sum(record.kind == "void" for record in journal.records)
        self._progress = Progress(
            operator,
            clock,
            noise=self._noise,
            surface=self._surface,
            planned=planned,
            voided=voided,
            unblinded=unblind,
            warnings=warnings,
        )
        journal.tell = self._progress.warn
        self._operator_answers = OperatorAnswers(self._progress, clock)
        self._interruptions = Interruptions(
            plate=plate,
            surface=self._surface,
            participant=participant,
            journal=journal,
            clock=clock,
            operator=operator,
            noise=self._noise,
            progress=self._progress,
            markers=self._markers,
            answers=self._operator_answers,
            hold_text=texts["session.hold"],
        )
        self._adjusting = Adjusting(
            surface=self._surface,
            participant=participant,
            journal=journal,
            clock=clock,
            markers=self._markers,
            progress=self._progress,
            watch=self._interruptions.watch,
            wait=self._wait,
        )
        self._answered = len(journal.records)  # number of records up to the last answer
        self._rewinds = False  # the surface was lost because a pilot was interrupted
        self._actions: Mapping[type, Callable[[Any], Answer]] = {
            Instruct: self._show,
            Rest: self._show,
            Feedback: self._feedback,
            Explore: self._explore,
            Ask: self._ask,
            Adjust: self._adjust,
            Present: self._present,
            Silence: self._silence,
            EndTrial: self._end_trial,
            EndBlock: self._end_block,
        }

    def run(self) -> RunOutcome:
        """Run until the end or until someone stops the session; the plate is silent afterwards.

        Raises
        ------
        PlateFault
            If the rig failed and the operator gave up. The run can be resumed.
        UserError
            If the journal cannot be written, or (on resuming) does not match the protocol.
        """
        self._markers.mark(Event.BEGIN)
        try:
            self._loop()
            self._surface.shut_down()
            self._journal.write("end")
        except StopRequested as request:
            self._surface.shut_down()
            self._journal.write("stop", reason=str(request) or "requested by the participant")
            return "stopped"
        except UserError:
            self._surface.shut_down()
            raise
        except BaseException as error:
            self._surface.shut_down()
            self._journal.write("stop", reason=f"{type(error).__name__}: {error}")
            raise
        finally:
            self._noise.stop()
            self._markers.mark(Event.END)
        self._progress.tell("done")
        return "complete"

    def _loop(self) -> None:
        """Carry out the steps: replay the ones in the journal, then continue live."""
        past = _past(self._journal.records)
        answer: Answer = None
        number = 0
        while True:
            try:
                step = self._steps.send(answer) if number else next(self._steps)
            except StopIteration:
                self._ask_again()  # the session was killed between the last step and the question
                return
            if number < len(past):
                answer = self._replay(step, past[number])
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
                self._ask_again()

    # From the journal -----------------------------------------------------------------------

    def _replay(self, step: Step, past: Past) -> Answer:
        """Return a step's answer from the journal, and note the resulting surface."""
        if not same_step(past.begun.data["what"], step_record(step)):
            raise UserError(
                f"journal {self._journal.path}, line {past.done.number + 1}: the protocol's "
                "next step differs from the recorded one; resume with the version of "
                "Slipscale that began the run (the journal's first line names it)"
            )
        answer = answer_from(past.done.data["answer"])
        if isinstance(step, Present):
            self._surface.presented(step, past.began_s)
        elif isinstance(step, Explore):
            self._surface.explored(step)
        elif isinstance(step, Silence):
            self._surface.silenced(step)
        elif isinstance(answer, Adjusted) and (wanted := self._surface.wanted):
            self._surface.adjusted(wanted.turned(answer.trace[-1][1]))
        return answer

    def _take_up(self, step: Step) -> None:
        """Switch from replayed to live steps: present the interrupted surface again."""
        self._progress.replayed()
        virtual = isinstance(self._clock, VirtualClock)
        self._journal.write("take_up", virtual=virtual)
        self._rewinds = virtual
        if not virtual:
            self._surface.interrupt()
        if not isinstance(step, Silence):
            self._interruptions.attempt(lambda: self._restore(step))

    @contextmanager
    def _when_it_was_presented(self) -> Iterator[Callable[[float], None]]:
        """Yield a function that sets a resumed pilot's clock to a presentation's original time.

        The clock is restored afterwards. The pilot thus continues as if it had not been
        interrupted: a texture changes with time, so each is explored at its original time.
        """
        clock = self._clock
        if not (self._rewinds and isinstance(clock, VirtualClock)):
            yield lambda _began_s: None
            return
        now_s = clock.now()
        try:
            yield clock.set
        finally:  # if the time were repeated, a fault at that time would repeat forever
            clock.set(now_s)
            self._rewinds = False

    # Live -----------------------------------------------------------------------------------

    def _live(self, step: Step, number: int) -> Answer:
        """Carry out a step, retrying as often as needed, and record its answer."""
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

    def _ask_again(self) -> None:
        """Repeat the questions that the operator selected; the new answers replace the old ones.

        The protocol does not receive the new answers, so its earlier steps are unchanged. No
        shipped protocol bases decisions on these answers.
        """
        for question in self._interruptions.take_questions():
            self._again(question)

    def _again(self, question: Ask) -> None:
        """Repeat a question; its new answer replaces the old one."""
        reply = self._interruptions.attempt(partial(self._ask_apart, question))
        self._journal.write(
            "answered_again", what=step_record(question), answer=answer_record(reply)
        )
        if question.name == CONSENT and isinstance(reply, Reply) and reply.value == "no":
            raise StopRequested("the participant withdrew consent")

    def _ask_apart(self, question: Ask) -> Reply:
        """Ask a question with the plate silent; the current surface is lost."""
        self._surface.hush()
        self._noise.stop()
        self._wait()
        return self._answer(question)

    def _show(self, step: Instruct | Rest) -> Reply:
        self._noise.stop()
        self._progress.tell("showing")
        return self._participant.perform(step, self._interruptions.watch)

    def _feedback(self, step: Feedback) -> Reply:
        return self._participant.perform(step, self._interruptions.watch)

    def _present(self, step: Present) -> Presented:
        if not self._surface.begins(step):
            self._restore(step)
        self._rewinds = False
        self._noise.start()
        self._progress.tell("presenting", level=step.surface.made.level)
        if self._tracking and self._surface.state == "silent":
            self._tracking.before(step, self._journal, self._clock)
        self._markers.mark(Event.ONSET, step)
        made = self._surface.present(step)
        self._markers.mark(Event.SETTLED, step)
        self._note_standard(step)
        return made

    def _explore(self, step: Explore) -> Reply:
        self._restore(step)
        reply = self._feel(step)
        self._surface.confirm()
        self._surface.explored(step)
        if self._stroke and (said := self._stroke.judged(step, self._contact.last)):
            self._feedback(said)
        return reply

    def _feel(self, step: Explore) -> Reply:
        """Have the participant explore the plate."""
        self._wait()
        with self._contact.measured(step, self._interruptions.watch) as watch:
            return self._participant.perform(step, watch)

    def _ask(self, step: Ask) -> Reply:
        self._restore(step)
        self._wait()
        reply = self._answer(step)
        try:
            self._surface.confirm()
        except PlateFault:
            # The surface was lost during the answer, which is recorded but never used.
            self._journal.write("discarded", name=step.name, answer=answer_record(reply))
            raise
        return reply

    def _adjust(self, step: Adjust) -> Adjusted:
        self._restore(step)
        self._wait()
        return self._adjusting.adjust(step)

    def _answer(self, step: Ask) -> Reply:
        """Have a question answered, after any previous ones that the participant returns to.

        An earlier question is repeated as if the operator had requested it: the journal contains
        both answers, and a session that is killed in between asks it again.
        """
        before = self._progress.before(step) if step.by == "participant" else None
        while True:
            reply = self._answer_once(replace(step, back=before is not None))
            if before is None or reply.value != BACK:
                return reply
            self._journal.write("ask_again", what=step_record(before))
            self._again(before)

    def _answer_once(self, step: Ask) -> Reply:
        """Have a question answered; if it is interrupted, record the unfinished entry."""
        begun = last_unfinished(self._journal.records, step)
        self._participant.unfinished = begun
        try:
            with self._contact.measured(step, self._interruptions.watch) as watch:
                if step.played and not self._hear(step, step.played, watch):
                    return Reply(value=NO_SOUND, onset_s=self._clock.now())
                if step.by == "operator":
                    reply = self._operator_answers.await_answer(step, self._participant, watch)
                else:
                    reply = self._participant.perform(step, watch)
        except UserError:
            raise  # usually the journal itself, so nothing can be written
        except BaseException:
            left = self._participant.unfinished
            if left != begun:
                trial = step.trial.number if step.trial else None
                self._journal.write(
                    "unfinished",
                    name=step.name,
                    trial=trial,
                    entry=left.entry,
                    rejected=left.rejected,
                )
            raise
        self._markers.mark(Event.ANSWER, step)
        return reply

    def _hear(self, step: Ask, played: Played, watch: Watch) -> bool:
        """Play a sound while the participant listens; return whether it could be played."""
        if self._sounds.missing:
            self._journal.write(NO_SOUND, name=step.name, reason=self._sounds.missing)
            self._progress.warn(f"no headphone test: {self._sounds.missing}")
            return False
        self._sounds.start(played.sound)
        try:
            listening = Feedback(text=played.text, duration_s=played.sound.duration_s)
            self._participant.perform(listening, watch)
        finally:
            self._sounds.stop()
        return True

    def _marker_lost(self, name: str, reason: str) -> None:
        """Report and record that an output no longer receives markers."""
        self._progress.warn(f"NO MARKERS on {name} any longer: {reason}")
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

    def _restore(self, step: Step) -> None:
        """If the surface was lost, present it and have it explored again before the step."""
        if self._surface.must_be_felt_again(step):
            self._noise.start()
            self._progress.tell("presenting")
            self._markers.mark(Event.ONSET, step)
            with self._when_it_was_presented() as at:
                made = self._surface.restore(at)
            self._markers.mark(Event.SETTLED, step)
            self._note_standard(step)
            trial = step.trial.number if step.trial else None
            for presented, answer in made:
                interval = {} if presented.interval is None else {"interval": presented.interval}
                self._journal.write(
                    "represented", trial=trial, **interval, answer=answer_record(answer)
                )

    def _note_standard(self, step: Step) -> None:
        """Record that the standard was repeated before a trial's surface, if it was."""
        if made := self._surface.take_standard_made():
            trial = step.trial.number if step.trial else None
            self._journal.write("standard_again", trial=trial, answer=answer_record(made))

    def _moved(self, kind: Kind, samples: list[Sample]) -> list[float] | None:
        """Pass on samples to the surface, and the position to the screen if a sensor measures it.

        Returns the times of changes that they triggered, as `SurfaceState.follow`.
        """
        if kind == "position" and samples and self._shows_finger:
            x_mm, y_mm = samples[-1].values
            self._participant.cursor_mm = x_mm, y_mm
        return self._surface.follow(kind, samples)

    def _wait(self) -> None:
        """Indicate to the operator that the session is waiting for the participant."""
        self._progress.tell("waiting", level=self._surface.level)


def last_unfinished(records: list[Record], step: Ask) -> Unfinished:
    """Return the unfinished entry of an interrupted answer from the journal."""
    trial = step.trial.number if step.trial else None
    for record in reversed(records):
        if record.kind in ("done", "answered_again"):
            break
        data = record.data
        if record.kind == "unfinished" and (data["name"], data["trial"]) == (step.name, trial):
            return Unfinished(entry=data["entry"], rejected=tuple(data["rejected"]))
    return Unfinished()


def _past(records: list[Record]) -> list[Past]:
    """Return the finished steps."""
    past: list[Past] = []
    for record in records:
        if record.kind == "begin":
            begun, began_s = record, record.time_s
        elif record.kind in BEGUN_ANEW:
            began_s = record.time_s
        elif record.kind == "done":
            past.append(Past(begun=begun, began_s=began_s, done=record))
    return past
