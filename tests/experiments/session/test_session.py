import contextlib
import signal
import sys
from collections import Counter

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.lab.blind_summary import summary
from slipscale.experiments.participants.base import StopRequested, Unfinished
from slipscale.experiments.session.interruptions import UNBLINDED
from slipscale.experiments.session.operator import Request, UnattendedOperator
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.questions.text import TextQuestion
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.replies import BACK
from slipscale.experiments.steps.steps import Ask, Explore, Instruct
from slipscale.faults import UserError
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.driver import PlateDriver
from slipscale.hardware.errors import GarbledReply, OverLimit, PlateFault, PlateRefused
from slipscale.hardware.signals import EndedBySignal, signals_raise
from tests.experiments.conftest import make_plan
from tests.support.scripted import ScriptedParticipant

linux = pytest.mark.skipif(sys.platform != "linux", reason="reads an open file by its number")


def sensible(step):
    """Answer any question with something that fits."""
    question = step.question
    if isinstance(question, NumberQuestion):
        return 42.0
    if isinstance(question, YesNoQuestion):
        return True
    if isinstance(question, TextQuestion):
        return 'moins "glissant",\tcollé'
    return question.options[0][0]


def tables(folder):
    """Return everything a data set says, but for the journals and their day."""
    return {
        path.relative_to(folder): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and "sourcedata" not in path.parts
    }


class Planned(UnattendedOperator):
    """An operator who asks for things at given moments: {poll number: request}."""

    def __init__(self, requests, retries=3):
        super().__init__(retries)
        self.requests = dict(requests)
        self.polls = 0
        self.told = []

    def tell(self, status):
        super().tell(status)
        self.told.append(status)

    def poll(self):
        self.polls += 1
        if self.polls in self.requests:
            return self.requests.pop(self.polls)
        if self._state == "paused":
            return Request(what="go_on")
        return super().poll()


def test_a_session_ends_complete_with_the_plate_silent(laboratory):
    assert laboratory.run() == "complete"
    assert laboratory.plate.twin.drive.target_um_pp in (None, 0.0)
    assert laboratory.records(kind="end")


def steps_done(content):
    return content.count(b'"kind":"done"')


@linux
def test_every_answer_is_on_disk_before_the_next_question_begins(laboratory, slow_disk):
    asked = []

    class Looking(ScriptedParticipant):
        def perform(self, step, watch):
            if isinstance(step, Ask | Instruct):
                asked.append(steps_done(slow_disk.kept))
            return super().perform(step, watch)

    laboratory.run(person=lambda _: Looking(sensible, laboratory.clock))
    begun = [each.data["what"] for each in laboratory.records(kind="begin")]
    screens = ("Ask", "Instruct", "EndBlock")
    places = [n for n, what in enumerate(begun) if what["type"] in screens]
    assert len(asked) == len(places) > 20
    for kept, place in zip(asked, places, strict=True):
        unkept = {what["type"] for what in begun[kept:place]}
        assert unkept <= {"Present", "Explore", "Silence", "EndTrial"}


@linux
def test_the_disk_works_while_the_participant_explores(laboratory, slow_disk):
    unkept = []

    class Stroking(ScriptedParticipant):
        def perform(self, step, watch):
            if isinstance(step, Explore) and not slow_disk.free.is_set():
                unkept.append(steps_done(slow_disk.kept) <= self.answer)
            slow_disk.free.set()
            reply = super().perform(step, watch)
            if isinstance(step, Ask) and step.trial:
                self.answer = laboratory.records()[-1].data["step"]
                slow_disk.free.clear()
            return reply

    laboratory.run(person=lambda _: Stroking(sensible, laboratory.clock))
    assert len(unkept) > 8
    assert all(unkept)


# The thread waits at least once for each question, of which there are more than 20.
@pytest.mark.parametrize("at", [3, 4, 9, 20])
def test_a_disk_that_fails_ends_the_session_with_the_plate_silent(laboratory, slow_disk, at):
    slow_disk.fails_at = at
    with pytest.raises(UserError, match=r"all responses before the last are on disk.*resume$"):
        laboratory.run()
    assert laboratory.plate.twin.drive.target_um_pp in (None, 0.0)
    slow_disk.fails_at = None
    lost = laboratory.records()
    assert laboratory.run() == "complete"
    assert laboratory.records()[: len(lost)] == lost


def test_the_participant_is_never_handed_an_amplitude(laboratory):
    laboratory.run(person=lambda _: ScriptedParticipant(sensible, laboratory.clock))
    for step in laboratory.person.seen:
        assert "amplitude" not in repr(step)
        assert "2.3" not in repr(step)


def test_the_operator_sees_no_amplitude(laboratory):
    operator = Planned({})
    laboratory.run(operator=operator)
    assert {status.level for status in operator.told} == {None}
    last = operator.told[-1]
    assert (last.state, last.done, last.planned) == ("done", 12, 12)


def test_wherever_a_pilot_is_interrupted_its_data_come_out_the_same(laboratory, tmp_path, plan):
    """The journal is cut after every single record, and the run gone on with."""
    whole = tmp_path / "whole"
    laboratory.folder = whole
    laboratory.run()
    build_dataset(whole)
    expected = tables(whole)
    lines = plan().journal_path(whole).read_bytes().splitlines(keepends=True)
    for kept in range(1, len(lines), 5):
        laboratory.folder = tmp_path / f"cut{kept}"
        path = plan().journal_path(laboratory.folder)
        path.parent.mkdir(parents=True)
        path.write_bytes(b"".join(lines[:kept]) + lines[kept][: kept % 7])
        assert laboratory.run() == "complete"
        build_dataset(laboratory.folder)
        assert tables(laboratory.folder) == expected, f"cut after record {kept - 1}"


def test_escape_stops_cleanly_and_the_run_can_be_resumed(laboratory):
    answers = iter([*["18-25", "woman"], False, StopRequested()])
    script = lambda _plan: ScriptedParticipant(answers, laboratory.clock)  # noqa: E731
    assert laboratory.run(person=script) == "stopped"
    assert laboratory.plate.twin.drive.target_um_pp in (None, 0.0)
    assert laboratory.records(kind="stop")
    assert laboratory.run(person=lambda _: ScriptedParticipant(sensible, laboratory.clock)) == (
        "complete"
    )
    felt = [
        record.data["answer"]["value"]
        for record in laboratory.records(kind="done")
        if (record.data["answer"] or {}).get("value") in (True, False)
    ]
    assert felt[0] is False  # the answer given before the stop was kept


@pytest.mark.parametrize("phase", ["present", "read_back", "check"])
@pytest.mark.parametrize("fault", ["lost", "time_out", "garbled", "refused", "busy"])
def test_after_a_fault_the_surface_is_presented_again_and_the_trial_flagged(
    laboratory, fault, phase
):
    laboratory.run(spec=f"mock:fault={fault}@{phase}/9")
    build_dataset(laboratory.folder)
    assert [r.data["code"] for r in laboratory.records(kind="fault")] == [fault]
    text = "".join(p.read_text() for p in laboratory.folder.glob("sub-01/beh/*_beh.tsv"))
    rows = [line.split("\t") for line in text.splitlines()]
    flags = [row[-1] for row in rows if row[0].isdigit()]
    assert len(flags) == 12
    assert sum("fault" in flag for flag in flags) == 1


def test_no_rating_is_taken_of_a_surface_that_has_gone(laboratory):
    """The plate dies silently while the participant types: the answer is kept, and asked again."""
    asked, gone = [], []

    def answer(step):
        asked.append(step.name)
        if step.name == "estimate" and laboratory.plate.vibration_level() > 1 and not gone:
            gone.append(step)
            laboratory.plate.twin.set_drive(
                type(laboratory.plate.twin.drive)(), laboratory.clock.now()
            )
            laboratory.clock.sleep(0.1)
        return sensible(step)

    laboratory.run(person=lambda _: ScriptedParticipant(answer, laboratory.clock))
    assert [r.data["name"] for r in laboratory.records(kind="discarded")] == ["estimate"]
    assert asked.count("estimate") == 9
    seen = [type(step) for step in laboratory.person.seen]
    again = max(i for i, step in enumerate(laboratory.person.seen) if step == gone[0])
    assert seen[again - 1] is Explore  # felt again before it was asked again


def test_after_a_suspended_computer_the_surface_is_felt_and_rated_again(laboratory, monkeypatch):
    monkeypatch.setattr(MockPlate, "frozen_s", PlateDriver.frozen_s)
    asked, gone = [], []

    def answer(step):
        asked.append(step.name)
        if step.name == "estimate" and laboratory.plate.vibration_level() > 1 and not gone:
            gone.append(step)
            laboratory.clock.suspend(20.0)
        return sensible(step)

    laboratory.run(person=lambda _: ScriptedParticipant(answer, laboratory.clock))
    (fault,) = laboratory.records(kind="fault")
    assert (fault.data["code"], fault.data["level_free"]) == ("frozen", True)
    assert fault.data["values"]["gap_s"] == pytest.approx(21.0)  # The answer takes 1 s.
    assert asked.count("estimate") == 9
    again = max(i for i, step in enumerate(laboratory.person.seen) if step == gone[0])
    assert isinstance(laboratory.person.seen[again - 1], Explore)


def test_a_fault_that_names_the_amplitude_is_told_without_it_unless_unblinded(laboratory):
    for unblind in (False, True):
        operator = Planned({})
        laboratory.folder /= str(unblind)
        with pytest.raises(PlateFault) as ended:
            # Fingers that press too hard: the drive's voltage does not suffice.
            laboratory.run(spec="mock:finger=0.01", operator=operator, unblind=unblind)
        told = [status.message for status in operator.told if status.state == "fault"]
        assert told
        assert all(("µm p-p was commanded" in text) == unblind for text in told)
        assert ("µm p-p was commanded" in str(ended.value)) == unblind
        assert "2.3 µm p-p was commanded" in laboratory.records(kind="fault")[0].data["message"]


@pytest.mark.parametrize(
    "fault",
    [
        PlateRefused("the generator: VOLT? returns 1.616, but 1.2 was set"),
        GarbledReply("the board answered 'HOLD,1.2000,nan', which cannot be read"),
        OverLimit("1.2 V peak at the plate is more than the card's full scale"),
    ],
)
def test_no_message_of_a_fault_names_the_amplitude_to_a_blinded_operator(laboratory, fault):
    class Failing(Planned):
        def poll(self):
            if laboratory.plate.vibration_level() > 1:
                raise fault
            return super().poll()

    operator = Failing({})
    with pytest.raises(type(fault)) as ended:
        laboratory.run(operator=operator)
    stops = [record.data["reason"] for record in laboratory.records() if record.kind == "stop"]
    events = summary(make_plan().journal_path(laboratory.folder)).events
    shown = [status.message for status in operator.told]
    shown += [text for event in events for text in (event.words, event.detail)]
    assert stops
    for text in (*shown, *stops, str(ended.value)):
        assert "1.2" not in text
    assert {record.data["message"] for record in laboratory.records(kind="fault")} == {
        fault.message
    }


def test_an_operator_who_unblinds_is_told_amplitudes_from_then_on_and_that_is_in_the_journal(
    laboratory,
):
    operator = Planned({poll: Request(what="unblind") for poll in (60, 80)})
    laboratory.run(operator=operator)
    blind = [status for status in operator.told if not status.unblinded]
    seeing = operator.told[len(blind) :]
    assert blind == operator.told[: len(blind)]
    assert not [status for status in blind if status.level is not None]
    assert {"0.5 µm p-p", "1.2 µm p-p", "2.3 µm p-p"} <= {status.level for status in seeing}
    [note] = laboratory.records(kind="note")
    assert note.data["text"].startswith("unblinded")


def test_a_run_begun_or_resumed_unblinded_is_in_the_journal_as_one_unblinded_later(laboratory):
    stop = Planned({30: Request(what="stop")})
    assert laboratory.run(operator=stop, unblind=True) == "stopped"
    assert [record.kind for record in laboratory.records()][:2] == ["header", "note"]
    later = Planned({60: Request(what="unblind")})
    laboratory.run(operator=later, unblind=True)  # told once per run, not at each request
    kinds = [record.kind for record in laboratory.records()]
    assert kinds[kinds.index("resume") + 1] == "note"
    notes = [record.data["text"] for record in laboratory.records(kind="note")]
    assert notes == [UNBLINDED] * 2


def test_a_blinded_run_has_no_note_of_unblinding(laboratory):
    laboratory.run()
    assert laboratory.records(kind="note") == []


def test_a_rig_that_stays_dead_ends_the_session_resumable(laboratory):
    spec = "mock:fault=" + "+".join(f"lost@{n}" for n in range(30, 60))
    with pytest.raises((PlateFault, UserError)):
        laboratory.run(spec=spec)
    assert laboratory.run() == "complete"


def test_a_voided_trial_is_kept_flagged_and_repeated(laboratory):
    operator = Planned({70: Request(what="void", reason="coughed")})
    laboratory.run(operator=operator)
    build_dataset(laboratory.folder)
    (void,) = laboratory.records(kind="void")
    assert void.data["reason"] == "coughed"
    name = f"sub-01/beh/sub-01_task-{void.data['task']}_run-01_beh.tsv"
    rows = [line.split("\t") for line in (laboratory.folder / name).read_text().splitlines()]
    header, *rows = rows
    flagged = [row for row in rows if "voided" in row[-1]]
    repeats = [row for row in rows if row[-2] == str(void.data["trial"])]
    assert [row[0] for row in flagged] == [str(void.data["trial"])]
    assert len(repeats) == 1
    surface = header.index("amplitude_um_pp")
    assert repeats[0][surface] == flagged[0][surface]


def test_every_poll_is_a_moment_at_which_a_void_or_a_pause_loses_nothing(laboratory, tmp_path):
    for poll in range(3, 110, 11):
        for what in ("void", "pause"):
            laboratory.folder = tmp_path / f"{what}{poll}"
            operator = Planned({poll: Request(what=what, reason="test")})
            assert laboratory.run(operator=operator) == "complete"
            build_dataset(laboratory.folder)
            voids = len(laboratory.records(kind="void"))
            text = "".join(p.read_text() for p in laboratory.folder.glob("sub-01/beh/*_beh.tsv"))
            assert sum(line[0].isdigit() for line in text.splitlines()) == 12 + voids


def test_a_pause_silences_and_presents_again(laboratory):
    operator = Planned({30: Request(what="pause")})
    laboratory.run(operator=operator)
    kinds = [r.kind for r in laboratory.records()]
    assert kinds[kinds.index("pause") : kinds.index("pause") + 2] == ["pause", "go_on"]


def test_an_exception_anywhere_silences_the_plate_and_is_journaled(laboratory):
    def fail(step):
        if step.name == "estimate":
            raise RuntimeError("a bug")
        return sensible(step)

    with pytest.raises(RuntimeError, match="a bug"):
        laboratory.run(person=lambda _: ScriptedParticipant(fail, laboratory.clock))
    assert laboratory.plate.twin.drive.target_um_pp in (None, 0.0)
    assert "a bug" in laboratory.records(kind="stop")[0].data["reason"]


def test_timed_out_trials_are_repeated_once(laboratory, plan):
    text = plan().study_text.replace("practice = 1", "practice = 0\nresponse_time_limit_s = 0.9")
    laboratory.run(plan(text))
    build_dataset(laboratory.folder)
    name = "sub-01/beh/sub-01_task-magnitudeestimation_run-01_beh.tsv"
    rows = [line.split("\t") for line in (laboratory.folder / name).read_text().splitlines()[1:]]
    timed_out = {row[0] for row in rows if "timed_out" in row[-1]}
    repeated = Counter(row[-2] for row in rows if row[-2] != "n/a")
    first = [row[0] for row in rows if row[-2] == "n/a"]
    assert timed_out
    assert set(repeated) == timed_out & set(first)
    assert set(repeated.values()) <= {1}


def test_a_changed_protocol_is_not_resumed_into_nonsense(laboratory, plan):
    operator = Planned({60: Request(what="stop")})
    laboratory.run(operator=operator)
    path = plan().journal_path(laboratory.folder)
    other = plan(seed=1)  # another order of surfaces
    assert other.journal_path(laboratory.folder) == path
    with pytest.raises(UserError, match="the protocol's next step differs"):
        laboratory.run(other)


def test_questions_are_asked_while_the_surface_stands(laboratory):
    """What the participant is asked about is on the plate at that moment, every time."""
    felt = []

    def answer(step: Ask):
        if step.name in ("estimate", "difference_felt"):
            felt.append((step.trial.number, laboratory.plate.vibration_level()))
        return sensible(step)

    laboratory.run(person=lambda _: ScriptedParticipant(answer, laboratory.clock))
    presented = [
        record.data["answer"]["commanded_level"]
        for record in laboratory.records(kind="done")
        if (record.data["answer"] or {}).get("type") == "Presented"
    ][1:]  # the first is the start of the descent
    assert [amplitude for _, amplitude in felt] == pytest.approx(presented, abs=0.02)


class Regretful(UnattendedOperator):
    """Voids a trial while the screen after its block is shown.

    ``ponders`` polls pass before the reason is typed; the participant goes on meanwhile.
    """

    def __init__(self, task, trial, ponders=0):
        super().__init__()
        self.wanted, self.left = (task, trial), ponders
        self.told, self.asked, self.busy_now = [], None, False

    @property
    def busy(self):
        return self.busy_now

    def tell(self, status):
        super().tell(status)
        self.told.append(status)
        now = status.voidable
        shown = status.state == "showing" and now and (now.task, now.number) == self.wanted
        if shown and self.asked is None:
            self.asked, self.busy_now = now, True

    def poll(self):
        if not self.busy_now:
            return super().poll()
        self.left -= 1
        if self.left >= 0:
            return None
        self.busy_now = False
        return Request(what="void", reason="sneezed", trial=self.asked)


DESCENT, ESTIMATES = "descendingdifference", "magnitudeestimation"


def trials_of(folder, task):
    """Return a task's rows, keyed by column."""
    name = f"sub-01/beh/sub-01_task-{task}_run-01_beh.tsv"
    header, *rows = [line.split("\t") for line in (folder / name).read_text().splitlines()]
    return [dict(zip(header, row, strict=True)) for row in rows]


@pytest.mark.parametrize("ponders", [0, 25])
@pytest.mark.parametrize("task, last", [(DESCENT, 4), (ESTIMATES, 8)])
def test_the_last_trial_of_a_task_can_be_voided_until_the_next_screen_is_left(
    laboratory, task, last, ponders
):
    operator = Regretful(task, last, ponders)
    assert laboratory.run(operator=operator) == "complete"
    build_dataset(laboratory.folder)
    *_, voided, again = trials_of(laboratory.folder, task)
    assert (voided["trial"], voided["flag"]) == (str(last), "voided")
    assert (again["trial"], again["repeats"]) == (str(last + 1), str(last))
    same = {"block", "phase", "series", "step", "amplitude_um_pp", "amplitude_before_um_pp"}
    assert all(voided.get(name) == again.get(name) for name in same)
    assert (operator.told[-1].done, operator.told[-1].planned) == (13, 13)
    other = DESCENT if task == ESTIMATES else ESTIMATES
    assert all(row["flag"] == "n/a" for row in trials_of(laboratory.folder, other))


def test_wherever_a_run_is_cut_a_voided_last_trial_is_repeated_once(laboratory, tmp_path, plan):
    """Cut after every record from the void on: also where the protocol had not been told."""
    whole = tmp_path / "whole"
    laboratory.folder = whole
    laboratory.run(operator=Regretful(ESTIMATES, 8))
    build_dataset(whole)
    expected = tables(whole)
    lines = plan().journal_path(whole).read_bytes().splitlines(keepends=True)
    (void,) = laboratory.records(kind="void")
    assert laboratory.records()[void.number - 1].data["what"]["type"] == "EndBlock"
    for kept in range(void.number + 1, len(lines)):
        laboratory.folder = tmp_path / f"cut{kept}"
        path = plan().journal_path(laboratory.folder)
        path.parent.mkdir(parents=True)
        path.write_bytes(b"".join(lines[:kept]))
        assert laboratory.run() == "complete"
        build_dataset(laboratory.folder)
        assert tables(laboratory.folder) == expected, f"cut after record {kept - 1}"


def test_once_the_participant_has_gone_on_a_task_is_over(laboratory):
    class Late(Regretful):
        def tell(self, status):
            if any(t.voidable and t.voidable.task == DESCENT for t in self.told) and (
                status.voidable is None and self.asked is None
            ):
                self.asked, self.busy_now = self.told[-1].voidable, True
            super().tell(status)

    operator = Late("nothing", 0)
    laboratory.run(operator=operator)
    assert operator.asked.task == DESCENT
    assert not laboratory.records(kind="void")
    assert any("its part of the run is over" in status.message for status in operator.told)


def test_a_reason_typed_slowly_voids_the_trial_it_is_about(laboratory):
    class Slow(Regretful):
        """Asks for the void of trial 2 when trial 3 is well under way."""

        def tell(self, status):
            now = status.voidable
            if now and (now.task, now.number) == (ESTIMATES, 2):
                self.asked = now
            if now and (now.task, now.number) == (ESTIMATES, 3) and self.asked:
                self.busy_now = not laboratory.records(kind="void")
            UnattendedOperator.tell(self, status)

    laboratory.run(operator=Slow("nothing", 0))
    build_dataset(laboratory.folder)
    flagged = [r["trial"] for r in trials_of(laboratory.folder, ESTIMATES) if r["flag"] != "n/a"]
    assert flagged == ["2"]


def test_a_practice_trial_voided_at_the_end_of_practice_is_repeated_as_practice(laboratory):
    laboratory.run(operator=Regretful(ESTIMATES, 4))
    build_dataset(laboratory.folder)
    rows = trials_of(laboratory.folder, ESTIMATES)
    assert [row["phase"] for row in rows] == ["practice"] * 5 + ["main"] * 4
    assert rows[4]["repeats"] == "4"
    assert rows[4]["amplitude_um_pp"] == rows[3]["amplitude_um_pp"]


def test_a_step_voided_between_two_series_belongs_to_its_own(laboratory, plan):
    text = plan().study_text.replace("series = 1", "series = 2")
    laboratory.run(plan(text), operator=Regretful(DESCENT, 4))
    build_dataset(laboratory.folder)
    rows = trials_of(laboratory.folder, DESCENT)
    assert [row["series"] for row in rows] == ["1"] * 5 + ["2"] * 4
    assert rows[4]["repeats"] == "4"


class Watching(UnattendedOperator):
    """Asks once for what ``wish`` makes of a status."""

    def __init__(self, wish):
        super().__init__()
        self.wish, self.wanted, self.asked, self.told = wish, None, False, []

    def tell(self, status):
        super().tell(status)
        self.told.append(status)
        if self.wanted is None and not self.asked:
            self.wanted = self.wish(status)

    def poll(self):
        if self._state == "paused":
            return Request(what="go_on")
        request, self.wanted = self.wanted, None
        self.asked = self.asked or request is not None
        return request or super().poll()


def test_the_trial_just_answered_can_be_voided_while_the_next_is_in_progress(laboratory):
    def wish(status):
        before = status.answered
        if before and (before.task, before.number) == (ESTIMATES, 5):
            return Request(what="void", reason="a slip of the finger", trial=before)
        return None

    laboratory.run(operator=Watching(wish))
    build_dataset(laboratory.folder)
    rows = trials_of(laboratory.folder, ESTIMATES)
    assert [row["trial"] for row in rows if row["flag"] == "voided"] == ["5"]
    assert [row["repeats"] for row in rows if row["repeats"] != "n/a"] == ["5"]


def test_the_trial_answered_last_in_another_task_is_not_offered(laboratory):
    operator = Watching(lambda _: None)
    laboratory.run(operator=operator)
    for status in operator.told:
        assert not status.answered or status.answered.task == status.voidable.task


@pytest.mark.parametrize("name, column", [("scale_top", "scale_top"), ("gender", None)])
def test_an_answer_about_the_run_can_be_asked_again_and_the_new_one_counts(
    laboratory, tmp_path, plan, name, column
):
    """Also where the run is cut at any record after that, and gone on with."""
    given = []

    def answer(step):
        if step.name != name:
            return sensible(step)
        given.append(77.0 if column else step.question.options[len(given)][0])
        return 123.0 if column and len(given) == 1 else given[-1]

    def wish(status):
        far = status.task == ESTIMATES and status.trial == 3 and status.state == "waiting"
        question = next((ask for ask in status.asked if ask.name == name), None)
        return Request(what="ask_again", question=question) if far and question else None

    def told():
        build_dataset(laboratory.folder)
        rows = trials_of(laboratory.folder, ESTIMATES)
        people = (laboratory.folder / "participants.tsv").read_text()
        return {row["scale_top"] for row in rows}, people

    script = lambda _: ScriptedParticipant(answer, laboratory.clock)  # noqa: E731
    whole = laboratory.folder = tmp_path / "whole"
    assert laboratory.run(person=script, operator=Watching(wish)) == "complete"
    assert len(given) == 2
    scale_tops, people = told()
    assert scale_tops == ({"77"} if column else {"42"})
    assert column or given[1] in people
    (again,) = laboratory.records(kind="answered_again")
    assert again.data["what"]["name"] == name
    lines = plan().journal_path(whole).read_bytes().splitlines(keepends=True)
    for kept in range(again.number + 1, len(lines), 7):
        laboratory.folder = tmp_path / f"cut{kept}"
        path = plan().journal_path(laboratory.folder)
        path.parent.mkdir(parents=True)
        path.write_bytes(b"".join(lines[:kept]))
        assert laboratory.run(person=script) == "complete"
        assert told() == (scale_tops, people)


def test_a_question_that_is_to_be_asked_again_is_asked_after_a_kill_too(laboratory, tmp_path, plan):
    """Cut at each record from the operator's request to the second answer, and one at the end."""

    def person(_plan):
        return ScriptedParticipant(sensible, laboratory.clock)

    def wish(status):
        far = status.task == ESTIMATES and status.trial == 3 and status.state == "waiting"
        return Request(what="ask_again", question=status.asked[0]) if far else None

    whole = laboratory.folder = tmp_path / "whole"
    laboratory.run(person=person, operator=Watching(wish))
    (wanted,), (again,) = (laboratory.records(kind=k) for k in ("ask_again", "answered_again"))
    lines = plan().journal_path(whole).read_bytes().splitlines(keepends=True)
    for kept in range(wanted.number + 1, again.number + 2):
        laboratory.folder = tmp_path / f"cut{kept}"
        path = plan().journal_path(laboratory.folder)
        path.parent.mkdir(parents=True)
        path.write_bytes(b"".join(lines[:kept]))
        assert laboratory.run(person=person) == "complete"
        (answered,) = laboratory.records(kind="answered_again")
        assert answered.data["what"] == wanted.data["what"]


def test_a_question_is_asked_again_with_the_plate_silent_and_the_surface_before_felt_anew(
    laboratory,
):
    still = []

    def answer(step):
        if step.name == "gender":
            still.append(laboratory.plate.twin.drive.target_um_pp)
        return sensible(step)

    def wish(status):
        far = status.task == DESCENT and status.trial == 2 and status.state == "waiting"
        return Request(what="ask_again", question=status.asked[1]) if far else None

    laboratory.run(
        person=lambda _: ScriptedParticipant(answer, laboratory.clock), operator=Watching(wish)
    )
    assert len(still) == 2
    assert still[1] in (None, 0.0)
    seen = laboratory.person.seen
    again = max(n for n, step in enumerate(seen) if getattr(step, "name", "") == "gender")
    # The descent goes on from the step before: that surface is felt again, then the next.
    assert [type(step) for step in seen[again + 1 : again + 3]] == [Explore, Explore]


def test_a_participant_goes_back_and_the_corrected_answers_count(laboratory, tmp_path, plan):
    """From the second question to the first, then again from there: nothing is before it."""
    given = []

    def answer(step):
        if step.trial:
            return sensible(step)
        given.append((step.name, step.back))
        if given.count(("gender", True)) == 1 and step.name == "gender":
            return BACK
        options = step.question.options if step.name in ("age_band", "gender") else ()
        return options[given.count((step.name, step.back)) % 2][0] if options else sensible(step)

    script = lambda _: ScriptedParticipant(answer, laboratory.clock)  # noqa: E731
    whole = laboratory.folder = tmp_path / "whole"
    assert laboratory.run(person=script) == "complete"
    asked = [("age_band", False), ("gender", True), ("age_band", False), ("gender", True)]
    assert given[:4] == asked
    (wanted,), (again,) = (laboratory.records(kind=k) for k in ("ask_again", "answered_again"))
    assert wanted.data["what"] == again.data["what"]
    assert wanted.data["what"]["back"] is False
    build_dataset(laboratory.folder)
    people = (whole / "participants.tsv").read_text()
    assert again.data["answer"]["value"] in people
    lines = plan().journal_path(whole).read_bytes().splitlines(keepends=True)
    laboratory.folder = tmp_path / "cut"
    path = plan().journal_path(laboratory.folder)
    path.parent.mkdir(parents=True)
    path.write_bytes(b"".join(lines[: wanted.number + 1]))  # killed before the new answer
    assert laboratory.run(person=lambda _: ScriptedParticipant(sensible, laboratory.clock))
    assert len(laboratory.records(kind="answered_again")) == 1


def test_a_stop_tells_its_reason_in_the_journal(laboratory):
    wish = lambda status: Request(what="stop", reason="the fire alarm") if status.done else None  # noqa: E731
    assert laboratory.run(operator=Watching(wish)) == "stopped"
    assert laboratory.records(kind="stop")[0].data["reason"].endswith(": the fire alarm")


def test_faults_and_pauses_are_no_part_of_the_time_that_is_told(laboratory):
    class Slow(Watching):
        def poll(self):
            if self._state == "paused":
                laboratory.clock.sleep(500.0)
            return super().poll()

    quick, slow = Watching(lambda _: None), Slow(
        lambda status: Request(what="pause") if status.done == 3 else None
    )  # fmt: skip
    laboratory.run(operator=quick)
    laboratory.folder /= "slow"
    laboratory.run(operator=slow)
    assert laboratory.records(kind="pause")
    spent = slow.told[-1].elapsed_s - quick.told[-1].elapsed_s
    assert 0 <= spent < 60  # the surface that was felt again, not the pause


def test_what_was_typed_when_something_came_is_journaled_offered_again_and_kept_on_resume(
    laboratory,
):
    """The participant has typed half an answer when the operator pauses, then stops."""
    offered = []

    class Typing(ScriptedParticipant):
        def perform(self, step, watch):
            if getattr(step, "name", "") != "estimate":
                return super().perform(step, watch)
            offered.append(self.unfinished)
            if len(offered) < 4:
                self.unfinished = Unfinished(entry="1234"[: len(offered)], rejected=("x",))
                raise (PlateFault("gone") if len(offered) < 3 else StopRequested)
            return super().perform(step, watch)

    script = lambda _: Typing(sensible, laboratory.clock)  # noqa: E731
    assert laboratory.run(person=script) == "stopped"
    assert laboratory.run(person=script) == "complete"
    typed = [Unfinished(), *(Unfinished(entry=e, rejected=("x",)) for e in ("1", "12", "123"))]
    assert offered[:4] == typed
    assert set(offered[4:]) == {Unfinished()}  # the next trials begin with nothing
    kept = [(r.data["entry"], r.data["name"]) for r in laboratory.records(kind="unfinished")]
    assert kept == [(entry, "estimate") for entry in ("1", "12", "123")]


def test_the_plate_moves_only_while_the_noise_is_at_its_level(laboratory):
    class Noise:
        """Fades for half a second, in which nothing may be heard of the plate."""

        state = "silent"
        moved = False

        def start(self):
            if self.state == "playing":
                return
            laboratory.clock.sleep(0.5)
            self.moved = self.moved or laboratory.plate.vibration_level() > 0
            self.state = "playing"

        def stop(self):
            self.state = "silent"

    noise, operator = Noise(), Watching(lambda s: Request(what="pause") if s.done == 6 else None)
    laboratory.run(noise=noise, operator=operator)
    assert not noise.moved
    assert noise.state == "silent"
    felt = [s for s in operator.told if s.state in ("presenting", "waiting") and s.task]
    assert {s.noise for s in felt if s.plate != "silent"} == {"playing"}
    assert {s.noise for s in operator.told if s.state == "showing"} == {"silent"}
    assert {s.plate for s in operator.told} == {"silent", "as commanded"}


def test_a_pause_is_no_lost_plate_and_a_fault_is_one(laboratory):
    operator = Watching(lambda s: Request(what="pause") if s.done == 6 else None)
    laboratory.run(operator=operator, spec="mock:fault=lost@9")
    told = {(s.state, s.plate) for s in operator.told if s.state in ("paused", "fault")}
    assert told == {("paused", "silent"), ("fault", "lost")}


def swallowed():
    """Have a signal arrive where a library drops every exception."""
    with contextlib.suppress(BaseException):
        signal.raise_signal(signal.SIGTERM)


class Swallowing(ScriptedParticipant):
    """A window whose library drops the exception of a signal in its first frame."""

    def perform(self, step, watch):
        swallowed()
        watch()
        return super().perform(step, watch)

    def hold(self, text, until):
        swallowed()
        super().hold(text, until)


def test_a_signal_that_a_library_swallows_ends_the_session_at_the_next_frame(laboratory):
    with pytest.raises(EndedBySignal), signals_raise():
        laboratory.run(person=lambda _: Swallowing(sensible, laboratory.clock))
    assert laboratory.records()[-1].kind == "stop"
    assert laboratory.plate.twin.drive.target_um_pp in (None, 0.0)
    assert not laboratory.records(kind="done")


class AwaitedInVain(UnattendedOperator):
    """Never says what a pause or a fault waits for; a signal is swallowed meanwhile."""

    def __init__(self, first=None):
        super().__init__()
        self.first = first

    def tell(self, status):
        super().tell(status)
        if status.state in ("paused", "fault"):
            swallowed()

    def poll(self):
        request, self.first = self.first, None
        return request


@pytest.mark.parametrize(
    "spec, asked", [("mock", Request(what="pause")), ("mock:fault=lost@3", None)]
)
def test_a_swallowed_signal_ends_a_session_that_waits_for_the_operator(laboratory, spec, asked):
    with pytest.raises(EndedBySignal), signals_raise():
        laboratory.run(
            person=lambda _: ScriptedParticipant(sensible, laboratory.clock),
            operator=AwaitedInVain(asked),
            spec=spec,
        )
