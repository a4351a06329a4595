from collections import Counter

import pytest

from experiments.dataset.bids import build_dataset
from experiments.journal.journal import Journal
from experiments.participants.base import StopRequested
from experiments.participants.scripted import ScriptedParticipant
from experiments.protocols.steps import Ask, Explore, NumberQuestion, TextQuestion, YesNoQuestion
from experiments.session.operator import Request, UnattendedOperator
from faults import UserError
from hardware.errors import PlateFault


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


def test_every_answer_is_on_disk_before_the_next_step_begins(laboratory, monkeypatch):
    order = []
    write = Journal.write

    def noting(journal, kind, **data):
        record = write(journal, kind, **data)
        stored = journal.path.read_bytes().count(b"\n")
        order.append((kind, stored == record.number + 1))
        return record

    monkeypatch.setattr(Journal, "write", noting)
    laboratory.run()
    kinds = [kind for kind, _ in order]
    assert all(durable for _, durable in order)
    assert kinds == ["header", *["begin", "done"] * (len(kinds) // 2 - 1), "end"]


def test_the_participant_is_never_handed_an_amplitude(laboratory):
    laboratory.run(person=lambda _: ScriptedParticipant(sensible, laboratory.clock))
    for step in laboratory.person.seen:
        assert "amplitude" not in repr(step)
        assert "2.3" not in repr(step)


def test_the_operator_sees_no_amplitude(laboratory):
    operator = Planned({})
    laboratory.run(operator=operator)
    assert {status.amplitude_um_pp for status in operator.told} == {None}
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
    text = "".join(p.read_text() for p in laboratory.folder.glob("sub-01/beh/*.tsv"))
    rows = [line.split("\t") for line in text.splitlines()]
    flags = [row[-1] for row in rows if row[0].isdigit()]
    assert len(flags) == 12
    assert sum("fault" in flag for flag in flags) == 1


def test_no_rating_is_taken_of_a_surface_that_has_gone(laboratory):
    """The plate dies silently while the participant types: the answer is kept, and asked again."""
    asked, gone = [], []

    def answer(step):
        asked.append(step.name)
        if step.name == "estimate" and laboratory.plate.vibration_um_pp() > 1 and not gone:
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
            text = "".join(p.read_text() for p in laboratory.folder.glob("sub-01/beh/*.tsv"))
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
    with pytest.raises(UserError, match="the protocol now takes another step"):
        laboratory.run(other)


def test_questions_are_asked_while_the_surface_stands(laboratory):
    """What the participant is asked about is on the plate at that moment, every time."""
    felt = []

    def answer(step: Ask):
        if step.name in ("estimate", "difference_felt"):
            felt.append((step.trial.number, laboratory.plate.vibration_um_pp()))
        return sensible(step)

    laboratory.run(person=lambda _: ScriptedParticipant(answer, laboratory.clock))
    presented = [
        record.data["answer"]["commanded_um_pp"]
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
    assert any("its part is over" in status.message for status in operator.told)


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
