"""A session's mailbox: other processes see its state, and ask for what a key would ask for."""

import json
import os
import stat
import sys
from dataclasses import replace

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.journal.locks import lock_file
from slipscale.experiments.session import mailbox as mailboxes
from slipscale.experiments.session.mailbox import (
    LiveRequest,
    Mailbox,
    TrialName,
    mailbox_of,
    post,
    read_status,
)
from slipscale.experiments.session.operator import (
    Operators,
    Request,
    SessionStatus,
    UnattendedOperator,
)
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.steps import Ask
from slipscale.experiments.steps.trial import Trial
from slipscale.faults import UserError

THIRD = Trial(task="t", number=3, total=8)
FOURTH = Trial(task="t", number=4, total=8)
AGE = Ask(name="age", question=NumberQuestion(prompt="?"))
STATUS = SessionStatus(
    state="waiting", task="t", trial=4, total=8, voidable=FOURTH, answered=THIRD, asked=(AGE,)
)


@pytest.fixture
def journal(tmp_path):
    return tmp_path / "sub-01_run-01_journal.jsonl"


@pytest.fixture
def mailbox(journal, monkeypatch):
    monkeypatch.setattr(mailboxes, "LOOK_S", 0.0)
    with Mailbox(mailbox_of(journal), ("participant 01", "study s")) as box:
        box.tell(STATUS)
        yield box


def ask(journal, what, **details):
    post(journal, LiveRequest(token=read_status(journal).token, what=what, **details))


def test_what_the_session_tells_is_read_by_others(mailbox, journal):
    told = read_status(journal)
    assert (told.state, told.trial, told.total, told.heading[0]) == (
        *("waiting", 4, 8),
        "participant 01",
    )
    assert (told.voidable, told.answered, told.asked) == (
        TrialName(task="t", number=4),
        TrialName(task="t", number=3),
        ("age",),
    )


@pytest.mark.parametrize("what", ["pause", "go_on", "retry", "stop", "note"])
def test_requests_come_in_order_and_once(mailbox, journal, what):
    ask(journal, what, reason="because")
    ask(journal, "pause")
    assert mailbox.poll() == Request(what=what, reason="because")
    assert mailbox.poll() == Request(what="pause")
    assert mailbox.poll() is None


def test_a_void_is_about_the_trial_that_was_seen(mailbox, journal):
    third = TrialName(task="t", number=3)
    ask(journal, "void", reason="slip", trial=third)
    assert mailbox.poll() == Request(what="void", reason="slip", trial=THIRD)
    mailbox.tell(SessionStatus(state="waiting", voidable=Trial(task="t", number=5, total=8)))
    ask(journal, "void", reason="slip", trial=third)
    assert mailbox.poll() is None
    assert "can no longer be voided" in read_status(journal).refused


def test_a_question_is_asked_again_by_its_name(mailbox, journal):
    ask(journal, "ask_again", question="age")
    assert mailbox.poll() == Request(what="ask_again", question=AGE)
    ask(journal, "ask_again", question="shoe_size")
    assert mailbox.poll() is None
    assert "was not asked" in read_status(journal).refused


@pytest.mark.parametrize("text", [b"", b"{", b"[]", b'{"what": "explode"}', b"\xff" * 30_000])
def test_what_is_no_request_is_thrown_away(mailbox, journal, text):
    path = mailbox_of(journal) / "requests/1.json"
    path.write_bytes(text)
    assert mailbox.poll() is None
    assert not path.exists()


def test_a_request_for_a_session_before_this_one_is_not_obeyed(journal, monkeypatch):
    monkeypatch.setattr(mailboxes, "LOOK_S", 0.0)
    with Mailbox(mailbox_of(journal), ()):
        old = read_status(journal).token
    with Mailbox(mailbox_of(journal), ()) as box:
        post(journal, LiveRequest(token=old, what="stop"))
        assert box.poll() is None


def test_what_a_crash_left_behind_is_cleared(journal):
    left = mailbox_of(journal) / "requests"
    left.mkdir(parents=True)
    (left / "1.json").write_text("{}")
    with Mailbox(mailbox_of(journal), ()):
        assert list(left.iterdir()) == []
    assert not mailbox_of(journal).exists()


@pytest.mark.skipif(sys.platform == "win32", reason="modes are POSIX's")
def test_nobody_but_the_owner_can_reach_it(mailbox, journal):
    for folder in (mailbox_of(journal), mailbox_of(journal) / "requests"):
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
def test_a_link_in_its_place_is_not_followed(journal, tmp_path):
    (tmp_path / "precious").mkdir()
    (tmp_path / "precious/file").touch()
    mailbox_of(journal).symlink_to(tmp_path / "precious")
    with Mailbox(mailbox_of(journal), ()):
        assert not mailbox_of(journal).is_symlink()
    assert (tmp_path / "precious/file").exists()


def test_without_a_place_for_it_the_session_goes_on(tmp_path):
    (tmp_path / "file").touch()
    with Mailbox(mailbox_of(tmp_path / "file" / "journal.jsonl"), ()) as box:
        box.tell(STATUS)
        assert box.poll() is None


def test_what_a_crashed_session_told_is_not_taken_for_the_next_ones(mailbox, journal):
    lock_file(journal).write_text("here\n1\n")
    assert read_status(journal) is None
    lock_file(journal).write_text(f"here\n{os.getpid()}\n")
    assert read_status(journal) is not None


def test_asking_a_session_that_is_over_is_refused(journal):
    request = LiveRequest.model_validate({"token": "0", "what": "stop"})
    with pytest.raises(UserError, match="no session of this run is accepting requests"):
        post(journal, request)
    assert read_status(journal) is None


def test_of_several_operators_all_are_told_and_each_is_heard(mailbox, journal):
    both = Operators(UnattendedOperator(), mailbox)
    both.tell(STATUS)
    ask(journal, "pause")
    assert both.poll() == Request(what="pause")
    assert not both.busy


def test_notes_go_into_the_journal_with_the_trial_untouched(laboratory, tmp_path):
    class Noting(UnattendedOperator):
        def __init__(self):
            super().__init__()
            self.words = iter(["the finger is wet", "a door slammed"])

        def poll(self):
            words = next(self.words, None)
            return Request(what="note", reason=words) if words else None

    laboratory.run(operator=Noting())
    assert [record.data["text"] for record in laboratory.records(kind="note")] == [
        "the finger is wet",
        "a door slammed",
    ]
    assert laboratory.records()[-1].kind == "end"
    build_dataset(laboratory.folder)
    sidecar = next(laboratory.folder.glob("sub-01/beh/*.json"))
    notes = json.loads(sidecar.read_text(encoding="utf-8"))["Slipscale"]["notes"]
    assert [note["text"] for note in notes] == ["the finger is wet", "a door slammed"]


SAID = Ask(name="estimate", question=NumberQuestion(prompt="How slippery?"), by="operator")


def test_an_answer_is_taken_for_the_question_it_was_typed_for_and_for_no_other(mailbox, journal):
    ask(journal, "answer", reason="12", trial=TrialName(task="t", number=4))
    assert mailbox.poll() is None
    assert read_status(journal).refused == "that question is over"
    mailbox.tell(replace(STATUS, answering=SAID))
    assert read_status(journal).answering == "How slippery?"
    ask(journal, "answer", reason="12", trial=TrialName(task="t", number=3))
    assert mailbox.poll() is None
    ask(journal, "answer", reason="13", trial=TrialName(task="t", number=4))
    assert mailbox.poll() == Request(what="answer", reason="13", trial=FOURTH)
