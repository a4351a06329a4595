"""What every page shows of the laboratory: warnings, a session that is silent, the first line."""

import json
import re
import shutil
import time
from dataclasses import replace
from types import SimpleNamespace

import pytest
from markupsafe import escape

from slipscale.experiments.lab.blind_summary import RunSummary
from slipscale.experiments.lab.console import state
from slipscale.experiments.lab.console.jobs import Job
from slipscale.experiments.lab.console.pages import day
from slipscale.experiments.session.mailbox import beat_ns, mailbox_of
from slipscale.faults.message import Message, as_data

ALL = ("/", "/live", "/study", "/data", "/pilot")
WARNING = "NO BACKUP of this run unless you correct this: --backup /media/x: no such folder"


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    place = tmp_path.with_name(f"{tmp_path.name}-home")
    monkeypatch.setenv("HOME", str(place))
    return place


def ended(folder, *, errors="", output="", status=0, kind="session", began_s=0.0):
    """Return a job that has ended, for what it wrote."""
    for name, text in (("output.txt", output), ("errors.txt", errors)):
        (folder / name).write_text(text)
    job = state_job(kind, folder, began_s)
    job.process = SimpleNamespace(poll=lambda: status)
    return job


def state_job(kind, folder, began_s):
    paths = {"output": folder / "output.txt", "errors": folder / "errors.txt"}
    return Job(kind=kind, about="participant 02", process=None, began_s=began_s, **paths)


def test_a_session_s_warning_is_on_every_page_until_somebody_has_read_it(visitor, session, status):
    with session(replace(status, warnings=(WARNING,))):
        for path in ALL:
            assert WARNING in visitor.see(path)
    page = visitor.see("/")  # the session is over, and nobody has read it
    fields = re.search(r'data-do="acknowledge" data-fields="([^"]+)"', page)[1]
    asked = json.loads(fields.replace("&#34;", '"'))
    assert visitor.ask("acknowledge", **asked)[0] == 200
    assert WARNING not in visitor.see("/")
    with session(replace(status, warnings=(WARNING,))):
        visitor.console.state.now(fresh=True)
        assert WARNING in visitor.see("/data")  # of another session


def test_what_went_wrong_at_the_end_is_a_warning(visitor, recorded, tmp_path):
    said = Message("NO BACKUP of this run: {fault}", fault="/media/x: cannot be written")
    line = json.dumps({"warning": as_data(said)})
    visitor.jobs.jobs["session"] = ended(tmp_path, errors=f"noise\n{line}\nbackup: elsewhere\n")
    assert "PAS DE SAUVEGARDE de ce passage" in visitor.see("/pilot?lang=fr")
    page = visitor.see("/pilot?lang=en")
    assert escape(said) in page
    assert "noise" not in page
    assert visitor.ask("acknowledge", session="0.0", sentence=said)[0] == 200
    assert escape(said) not in visitor.see("/pilot")
    visitor.jobs.jobs["session"].began_s = 1.0
    assert escape(said) in visitor.see("/pilot")  # of another session


def test_a_session_whose_journal_has_gone_is_steered_where_it_goes_on(
    visitor, session, status, words_of, home
):
    with session(status) as (box, journal):
        journal.moved = lambda path: box.move(mailbox_of(path))
        journal.tell = lambda said: box.tell(replace(status, warnings=(said,)))
        shutil.rmtree(journal.path.parent)
        journal.write("note", text="it goes on")
        assert journal.path.is_relative_to(home)
        page = visitor.see("/live")
        assert "THE JOURNAL IS MISSING" in page
        assert "Pause" in words_of(page)
        token = re.search(r"token&#34;: &#34;(\w+)", page)[1]
        assert visitor.ask("ask", token=token, what="pause")[0] == 200
        assert box.poll().what == "pause"


def test_a_session_that_does_not_answer_is_told_on_every_page(
    visitor, session, status, monkeypatch
):
    """A session that was stopped, or a computer that stands, looked like any other."""
    now_s = [time.monotonic()]
    monkeypatch.setattr(state, "time", SimpleNamespace(monotonic=lambda: now_s[0]))
    with session(status) as (box, journal):
        visitor.see("/")
        now_s[0] += 4
        assert "has not responded" not in visitor.see("/")
        now_s[0] += 4
        for path in ALL:
            assert "participant 02 has not responded for 8 s" in visitor.see(path)
        before_ns = beat_ns(journal.path)
        while beat_ns(journal.path) == before_ns:  # the file system's clock is a coarse one
            box.poll()
        assert "has not responded" not in visitor.see("/")


def test_the_first_line_shows_the_state_of_the_laboratory(visitor, session, status, words_of, lab):
    with session(replace(status, state="paused")):
        for path in ALL:
            page = words_of(visitor.see(path))
            assert f"laboratory {lab.name} study" in page
            assert "plate serial:COM9 session participant 02, running · PAUSED disk" in page
            assert re.search(r"disk \d+\.\d GB free backup no backup folder set", page)


def test_runs_without_a_backup_are_counted_in_the_first_line(visitor, recorded, lab, words_of):
    (lab / "copy").mkdir()
    (lab / "slipscale.toml").write_text('study = "biet2007"\nbackup = "copy"\n')
    assert "backup 2 runs not copied" in words_of(visitor.see("/"))


def test_times_are_those_of_the_computer_s_clock(visitor, recorded, monkeypatch, words_of):
    page = words_of(visitor.see("/"))
    began = re.search(r"\d{4}-\d\d-\d\d \d\d:\d\d", page)[0]
    monkeypatch.setenv("TZ", "Asia/Kolkata")
    time.tzset()
    try:
        assert began not in words_of(visitor.see("/"))
        assert "UTC" not in words_of(visitor.see("/"))
    finally:
        monkeypatch.undo()
        time.tzset()


def test_a_session_that_began_and_failed_did_begin(visitor, recorded, tmp_path, words_of):
    job = ended(tmp_path, errors="the line is dead\n", status=3, began_s=time.time() + 60)
    visitor.jobs.jobs["session"] = job
    assert "The session did not start: the line is dead" in words_of(visitor.see("/"))
    visitor.jobs.jobs["session"].began_s = 0.0
    page = words_of(visitor.see("/"))
    assert "Every answer given so far is saved. Cause: the line is dead" in page


def test_a_session_that_was_killed_is_not_said_to_have_ended_by_its_last_warning(
    visitor, recorded, tmp_path, words_of
):
    warned = json.dumps({"warning": "no masking noise"})
    visitor.jobs.jobs["session"] = ended(tmp_path, errors=f"{warned}\n", status=-9)
    page = words_of(visitor.see("/"))
    assert "Cause: the program was stopped from outside (signal SIGKILL)" in page
    assert "Cause: no masking noise" not in page
    visitor.jobs.jobs["session"] = ended(tmp_path, errors=f"{warned}\n", status=1)
    assert "Cause: exit status 1" in words_of(visitor.see("/"))


@pytest.mark.parametrize("passed", [True, False])
def test_begin_is_demoted_while_something_is_not_ready(
    visitor, recorded, tmp_path, passed, monkeypatch
):
    monkeypatch.setattr(day, "_interrupted", lambda _: [])  # a run to resume comes first
    found = [{"name": "plate", "passed": passed, "detail": "no answer", "remedy": ""}]
    job = ended(tmp_path, output=json.dumps(found), kind="check")
    visitor.jobs.jobs["check"] = job
    page = visitor.see("/")
    begin = re.search(r'<button [^>]*data-do="begin"[^>]*>Begin the session', page)[0]
    assert ('class="main"' in begin) == passed
    assert ("found a problem. Begin" in begin) != passed
    assert re.search(r"Checked \d{4}-\d\d-\d\d \d\d:\d\d\.", page)


def test_a_rehearsal_leaves_a_trace(visitor, recorded, lab, words_of):
    shutil.copytree(lab / "data", lab / "pilots/rehearsals")
    page = words_of(visitor.see("/"))
    assert "Rehearsals rehearsal participant 01 complete" in page


def test_what_is_not_there_is_not_linked(visitor, recorded, lab):
    results = lab / "data/derivatives/slipscale"
    results.mkdir(parents=True)
    (lab / "data/sourcedata/unblinded.json").write_text(
        json.dumps([{"unblinded_utc": "2026-11-20T09:00:00+00:00", "done": 1, "planned": 12}])
    )
    (results / "table3.csv").write_text("amplitude_um_pp,n\n1,2\n")
    page = visitor.see("/data")
    assert "/data/download" in page
    assert "/data/report" not in page
    (results / "report.html").write_text("<p>")
    assert "/data/report" in visitor.see("/data")
    shutil.rmtree(lab / "data")
    visitor.console.state.now(fresh=True)
    assert "/data/download" not in visitor.see("/data")


def test_questions_are_named_in_words(visitor, session, status, words_of, monkeypatch):
    doing = RunSummary(doing="Ask:difference_felt")
    monkeypatch.setattr(state, "summary", lambda _: doing)
    with session(status):
        assert "answers: is there a difference" in words_of(visitor.see("/live"))


def test_keys_are_listed_where_they_are_asked_for(visitor):
    page = visitor.see("/")
    assert 'data-open="keys" data-key="?"' in page
    assert page.count("<kbd>") == 7
