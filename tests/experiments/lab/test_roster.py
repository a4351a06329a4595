"""Who is done, who is next, who returns: as the journals have it."""

import json

import pytest

from slipscale.commands import main
from slipscale.experiments.cli import sessions
from slipscale.experiments.dataset.withdrawal import withdraw
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.lab.folder import init
from slipscale.experiments.lab.roster import read_roster
from slipscale.experiments.study.file import parse_study, study_text
from slipscale.hardware.clock import VirtualClock

TEXT = study_text("biet2007")
VISITS = TEXT.replace("seed = 2007", 'seed = 2007\nsessions = ["01", "02"]')


def roster(folder, text=TEXT):
    return read_roster(folder, parse_study(text, "s"), text)


@pytest.fixture
def recorded(tmp_path, record_runs):
    return lambda *people, **changes: record_runs(tmp_path, *people, **changes)


def cut(folder, participant):
    """Interrupt a participant's run in the middle."""
    path = next((folder / "sourcedata" / f"sub-{participant}").glob("*_journal.jsonl"))
    path.write_bytes(b"".join(path.read_bytes().splitlines(keepends=True)[:40]))
    return path


def test_an_empty_folder_begins_with_the_first(tmp_path):
    found = roster(tmp_path)
    assert (found.people, found.new, found.planned) == ((), "01", 12)


def test_each_has_a_state_a_place_and_an_order(recorded):
    folder = recorded("01", "02", "03")
    cut(folder, "02")
    found = roster(folder)
    assert [(p.label, p.state, p.place) for p in found.people] == [
        ("01", "done", 1),
        ("02", "interrupted", 2),
        ("03", "done", 3),
    ]
    assert found.people[0].order == ("descendingdifference", "magnitudeestimation")
    assert found.new == "04"


def test_a_damaged_journal_is_told_as_such(recorded):
    folder = recorded("01")
    path = cut(folder, "01")
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join([*lines[:5], b"rubbish\n", *lines[6:]]))
    assert roster(folder).people[0].state == "damaged"


def test_a_session_that_runs_now_is_known_and_nobody_else_begins(
    recorded, tmp_path, monkeypatch, capsys
):
    folder = recorded("01")
    path = cut(folder, "01")
    with Journal.reopen(path, VirtualClock()):
        found = roster(folder)
        assert (found.people[0].state, found.running.path) == ("running now", path)
        monkeypatch.chdir(tmp_path)
        init(tmp_path, {"data": ".", "plate": "serial:COM9"}, None)
        assert main(["next", "--yes"]) == 2
        assert "a session is running" in capsys.readouterr().err
    assert roster(folder).people[0].state == "interrupted"


def test_who_withdrew_is_replaced_first(recorded):
    folder = recorded("01", "02")
    withdraw(folder, "01")
    found = roster(folder)
    assert [(p.label, p.state) for p in found.people] == [("01", "withdrew"), ("02", "done")]
    assert found.new == "R01"


EXCLUDING = TEXT + '\n[analysis]\nexclusions = ["zeros", "faults"]\n'


def excluded(folder, flags):
    """Write what an analysis writes, as far as it tells who was excluded."""
    results = folder / "derivatives/slipscale"
    results.mkdir(parents=True, exist_ok=True)
    (results / "results.json").write_text(json.dumps({"excluded": flags}))


def test_who_the_analysis_excluded_is_told_with_the_rule(recorded, monkeypatch, capsys, tmp_path):
    folder = recorded("01", "02")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(EXCLUDING)
    init(tmp_path, {"study": "mine.toml", "data": "."}, None)
    said = []
    for flags in (None, {}, {"sub-02": ["zeros"]}):
        if flags is not None:
            excluded(folder, flags)
        assert main(["participants"]) == 0
        said.append(capsys.readouterr().out)
    assert "to see who is excluded (the study's exclusion rules: zeros, faults)" in said[0]
    assert "excludes no participants" in said[1]
    assert "participant 02 is excluded because of zeros (analysis of 20" in said[2]
    assert main(["participants", "--json"]) == 0
    people = json.loads(capsys.readouterr().out)["people"]
    assert [(each["state"], each["excluded"]) for each in people] == [
        ("done", []),
        ("done", ["zeros"]),
    ]


@pytest.mark.parametrize("text", ["", "{", "[]", '{"excluded": 1}', '{"excluded": {"01": 3}}'])
def test_results_that_are_being_written_exclude_nobody(recorded, text):
    folder = recorded("01")
    excluded(folder, {})
    (folder / "derivatives/slipscale/results.json").write_text(text)
    found = roster(folder, EXCLUDING)
    assert (found.excluded, found.analysed_utc, found.exclusions) == ([], "", ("zeros", "faults"))


def test_numbers_go_on_as_they_were_written(recorded):
    assert roster(recorded("P001", "P002")).new == "P003"


def test_a_gap_is_filled_before_the_next_number(recorded):
    assert roster(recorded("01", "03")).new == "02"


def test_who_has_another_session_planned_returns(recorded):
    folder = recorded("01", study_text=VISITS, session="01")
    found = roster(folder, VISITS)
    person = found.person("01")
    assert (person.state, str(person.next_visit)) == ("returns", "session 02, run 01")
    recorded("01", study_text=VISITS, session="02")
    assert roster(folder, VISITS).person("01").state == "done"


def test_a_run_beyond_the_plan_is_listed_and_not_waited_for(recorded):
    folder = recorded("01")
    recorded("01", run="02")
    visits = roster(folder).person("01").visits
    assert [(visit.run, visit.planned) for visit in visits] == [("01", True), ("02", False)]


def test_once_all_have_begun_nobody_new_is_next(recorded):
    text = TEXT.replace("participants = 12", "participants = 1")
    assert roster(recorded("01", study_text=text), text).new is None


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """Make a laboratory folder and this the current one; sessions are only noted."""
    monkeypatch.chdir(tmp_path)
    init(tmp_path, {"plate": "serial:COM9"}, None)
    begun = []
    monkeypatch.setattr(
        sessions, "_begin", lambda out, plan, setting: begun.append((out, plan, setting)) or 0
    )
    return begun


def test_next_begins_the_next_participant_on_the_folders_plate(lab, tmp_path, record_runs, capsys):
    record_runs(tmp_path / "data", "01", mode="participant")
    assert main(["next", "--yes"]) == 0
    [(out, plan, setting)] = lab
    assert (str(out), plan.participant, plan.mode, setting.plate) == (
        *("data", "02"),
        *("participant", "serial:COM9"),
    )
    assert "next: participant 02, study biet2007, plate serial:COM9" in capsys.readouterr().out


def test_next_asks_first(lab, monkeypatch, capsys):
    assert main(["next"]) == 2
    assert "add --yes" in capsys.readouterr().err
    monkeypatch.setattr("sys.stdin", type("Terminal", (), {"isatty": lambda _: True})())
    monkeypatch.setattr("builtins.input", lambda _: "")
    assert main(["next"]) == 1
    monkeypatch.setattr("builtins.input", lambda _: "y")
    assert main(["next"]) == 0
    assert len(lab) == 1


def test_an_input_that_ends_at_a_question_is_an_interruption(
    lab, tmp_path, record_runs, monkeypatch, capsys
):
    def ended(_question):
        raise EOFError

    record_runs(tmp_path / "data", "01", mode="participant")  # on another plate, so `run` asks
    monkeypatch.setattr("sys.stdin", type("Terminal", (), {"isatty": lambda _: True})())
    monkeypatch.setattr("builtins.input", ended)
    for words in (["next"], ["lab", "init", "other"], ["run", "--participant", "02"]):
        assert main(words) == 130
        said = capsys.readouterr().err.splitlines()[-1]
        assert said.endswith("input ended before the question was answered, so nothing was begun")
    assert lab == []


def test_next_takes_who_returns_by_name(lab, tmp_path, record_runs):
    (tmp_path / "two.toml").write_text(VISITS)
    (tmp_path / "slipscale.toml").write_text('study = "two.toml"\nplate = "serial:COM9"\n')
    record_runs(tmp_path / "data", "01", study_text=VISITS, session="01")
    assert main(["next", "--yes", "--participant", "01"]) == 0
    assert main(["next", "--yes"]) == 0
    assert [(plan.participant, plan.session) for _, plan, _ in lab] == [("01", "02"), ("02", "01")]


def test_next_refuses_a_plate_that_nobody_feels_and_rehearses_when_told(lab, tmp_path, capsys):
    (tmp_path / "slipscale.toml").write_text("")
    assert main(["next", "--yes"]) == 2
    assert "slipscale next --pilot" in capsys.readouterr().err
    assert main(["next", "--yes", "--pilot"]) == 0
    [(out, plan, _)] = lab
    assert (out.as_posix(), plan.mode) == ("pilots/rehearsals", "pilot")


def test_participants_says_who_is_where(lab, tmp_path, record_runs, capsys):
    record_runs(tmp_path / "data", "01", "02", mode="participant")
    cut(tmp_path / "data", "02")
    assert main(["participants"]) == 0
    out = capsys.readouterr().out
    assert "2 of 12 planned participants have started; 1 finished" in out
    assert "participant 02: To continue: slipscale resume data/sourcedata/sub-02" in out
    assert "next: participant 03" in out


def test_participants_counts_the_runs_without_a_backup(lab, tmp_path, record_runs, capsys):
    record_runs(tmp_path / "data", "01", mode="participant")
    assert main(["participants"]) == 0
    assert "1 run has no complete backup: sub-01_run-01" in capsys.readouterr().out


def test_next_says_what_changed_since_the_last_participant(lab, tmp_path, record_runs, capsys):
    record_runs(tmp_path / "data", "01", mode="participant", study_text=TEXT + "# earlier")
    main(["next", "--yes"])
    assert "has changed since sub-01" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["next", "participants"])
def test_without_a_laboratory_folder_they_say_how_to_make_one(
    tmp_path, monkeypatch, capsys, command
):
    monkeypatch.chdir(tmp_path)
    assert main([command]) == 2
    assert "slipscale lab init" in capsys.readouterr().err


def test_a_note_without_a_session_is_refused(lab, capsys):
    assert main(["note", "a", "door"]) == 2
    assert "no session is running in data and pilots/rehearsals" in capsys.readouterr().err
