import errno
import io
import json
import os
import re
import subprocess
import sys
from contextlib import redirect_stdout
from pathlib import Path

import pytest

from slipscale import __version__, commands
from slipscale.commands import main
from slipscale.experiments.cli.lab import LONGEST_NOTE
from slipscale.experiments.cli.sessions import report_end
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.participants.psychopy_window import keyboard
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
from slipscale.experiments.running.preflight import PlannedSession, check, check_display
from slipscale.experiments.session.mailbox import LiveRequest
from slipscale.experiments.study.file import study_text
from slipscale.faults import UserError


def run(capsys, *words):
    status = main(list(words))
    said = capsys.readouterr()
    return status, said.out, said.err


def test_help_names_every_command(capsys):
    status, out, _ = run(capsys, "--help")
    assert status == 0
    assert all(name in out for name in commands.COMMANDS)


@pytest.mark.parametrize("command", commands.COMMANDS)
def test_every_command_has_help(capsys, command):
    with pytest.raises(SystemExit) as ending:
        main([command, "--help"])
    assert ending.value.code == 0
    assert f"slipscale {command}" in capsys.readouterr().out


def test_a_word_that_is_no_command_is_answered_with_those_there_are(capsys):
    status, _, err = run(capsys, "anlyse")
    assert status == 2
    assert "analyse" in err


def test_help_imports_nothing_heavy():
    code = (
        "import sys; from slipscale import commands; commands.main(['--help']); "
        "print(sorted(m for m in sys.modules if m.split('.')[0] in "
        "('numpy', 'pandas', 'psychopy', 'matplotlib', 'rich', 'pydantic', 'argparse', 'scipy')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize(
    "words, complaint",
    [
        (["run", "nothing.toml", "--participant", "01"], "biet2007"),
        (["run", "--participant", "Jane Doe"], "letters and digits only"),
        (["run", "--participant", "01", "--language", "tlh"], "en, fr"),
        (["resume", "nothing.jsonl"], "nothing.jsonl: No such file"),
        (
            ["resume", "a-file"],
            "a-file: its first line is incomplete; expected a Slipscale journal",
        ),
        (["note", "x" * 2001], "the note has 2001 characters; expected at most 2000"),
        (["study", "validate", "nothing.toml"], "No such file"),
        (["pilot", "--participants", "0"], "expected 1 or more"),
        (["pilot", "--seed", "-4"], "expected 0 or more"),
        (["run", "--participant", "01", "--seed", "-1"], "expected 0 or more"),
        (["pilot", "--plate", "serial:X"], "expected mock"),
        (["pilot", "--out", "a-file"], "a-file: Not a directory"),
        (["run", "--participant", "01", "--out", "a-file"], "a-file.*: Not a directory"),
        (["pilot", "--language", "tlh", "--participants", "1"], "en, fr"),
    ],
)
def test_a_users_mistake_is_one_sentence_and_exit_2(
    capsys, tmp_path, monkeypatch, words, complaint
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a-file").write_text("not a folder")
    status, _, err = run(capsys, *words)
    assert status == 2
    assert re.search(complaint, err)
    assert "Traceback" not in err


def test_a_new_study_is_valid_and_never_overwrites(capsys, tmp_path):
    path = tmp_path / "mine.toml"
    assert run(capsys, "study", "new", str(path))[0] == 0
    status, out, _ = run(capsys, "study", "validate", str(path))
    assert (status, "no fault" in out) == (0, True)
    status, _, err = run(capsys, "study", "new", str(path))
    assert (status, "already exists" in err) == (2, True)


def test_a_disk_that_fails_while_a_page_is_written_is_one_sentence(capsys, tmp_path, monkeypatch):
    (tmp_path / "t.csv").write_text("label,n,mean,sd,scale_maximum\na,5,2.40,1.14,9\n")

    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("slipscale.analysis.reconstruction_page.page.render", full)
    page = str(tmp_path / "p.html")
    status, _, err = run(capsys, "reconstruct", str(tmp_path / "t.csv"), "--html", page)
    assert (status, "a file: cannot be read or written (No space left" in err) == (2, True)


def test_a_full_disk_leaves_no_half_a_study_file(capsys, tmp_path, monkeypatch):
    def full(self, content, **_):
        self.touch()
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    path = tmp_path / "mon étude.toml"
    with monkeypatch.context() as patched:
        patched.setattr(Path, "write_bytes", full)
        status, _, err = run(capsys, "study", "new", str(path))
    assert (status, "No space left" in err) == (2, True)
    assert list(tmp_path.iterdir()) == []
    status, out, _ = run(capsys, "study", "new", str(path))
    assert (status, f"slipscale study validate '{path}'" in out) == (0, True)


def test_study_show_tells_the_orders_that_the_participant_gets(capsys, laboratory, plan):
    _, out, _ = run(capsys, "study", "show", "--participant", "07")
    laboratory.run(plan(participant="07"))
    given = [
        record.data["what"]["surface"]["level"]
        for record in laboratory.records(plan(participant="07"), kind="begin")
        if record.data["what"]["type"] == "Present"
        and (record.data["what"]["trial"] or {}).get("task") == "magnitudeestimation"
    ]
    line = next(
        line for line in out.splitlines() if line.strip().startswith("magnitudeestimation ")
    )
    assert [float(word.strip("()")) for word in line.split()[1:]] == given


def small(folder, **changes):
    plans = pilot_plans("biet2007", participants=2, seed=None, language=None)
    run_pilot(folder, plans, tell=lambda _: None)
    return folder


def files(folder):
    return {
        p.relative_to(folder): p.read_bytes()
        for p in folder.rglob("*")
        if p.is_file() and "sourcedata" not in p.parts
    }


def test_an_interrupted_pilot_is_completed_to_the_same_data(tmp_path):
    whole, cut = small(tmp_path / "whole"), tmp_path / "cut"
    small(cut)
    second = cut / "sourcedata/sub-02/sub-02_run-01_journal.jsonl"
    second.write_bytes(second.read_bytes()[:20_000])
    for name in files(cut):
        (cut / name).unlink()
    assert files(small(cut)) == files(whole)


def test_a_pilot_interrupted_before_its_first_record_can_be_run_again(tmp_path):
    (tmp_path / "sourcedata" / "sub-01").mkdir(parents=True)
    assert (small(tmp_path) / "participants.tsv").exists()


def test_resume_goes_on_with_a_pilot_as_a_pilot(capsys, tmp_path):
    whole, cut = small(tmp_path / "whole"), small(tmp_path / "cut")
    journal = cut / "sourcedata/sub-01/sub-01_run-01_journal.jsonl"
    journal.write_bytes(journal.read_bytes()[:15_000])
    status, out, _ = run(capsys, "resume", str(journal))
    assert (status, "complete" in out) == (0, True)
    assert files(cut) == files(whole)
    status, _, err = run(capsys, "resume", str(journal))
    assert (status, "this run is complete" in err) == (2, True)


def test_a_pilot_refuses_a_folder_that_holds_anything_else(tmp_path):
    (tmp_path / "thesis.docx").write_text("dear to somebody")
    with pytest.raises(UserError, match="is not empty"):
        small(tmp_path)
    other = small(tmp_path / "other")
    plans = pilot_plans("biet2007", participants=2, seed=99, language=None)
    with pytest.raises(UserError, match="contains another pilot"):
        run_pilot(other, plans, tell=lambda _: None)
    assert read_plan(other / "sourcedata/sub-01/sub-01_run-01_journal.jsonl")[0].seed == 2007


def test_a_participant_who_has_a_run_is_refused_by_its_journal(capsys, tmp_path):
    small(tmp_path)
    status, _, err = run(capsys, "run", "--participant", "01", "--out", str(tmp_path))
    assert status == 2
    assert "sub-01_run-01_journal.jsonl" in err


def test_check_is_always_a_whole_list_and_gives_the_remedy(display, tmp_path):
    planned = PlannedSession(study="biet2007", plate="mock", out=tmp_path, full_screen=False)
    found = {finding.name: finding for finding in check(planned, lambda _: None)}
    assert list(found) == ["study", "folder", "participant", "plate", "sound", "markers", "display"]
    assert [name for name, f in found.items() if f.passed is False] == []
    assert "2.3" in found["plate"].detail


def test_check_opens_the_window_as_a_session_does_and_tells_of_unstamped_keys(
    display, tmp_path, monkeypatch
):
    planned = PlannedSession(study="biet2007", plate="mock", out=tmp_path, full_screen=False)
    assert "key presses have time stamps" in check_display(planned).detail

    def deny(_clock):
        raise RuntimeError("not allowed to listen")

    monkeypatch.setattr(keyboard, "Stamps", deny)
    found = check_display(planned)
    assert (found.passed, "does not time-stamp key presses" in found.detail) == (None, True)
    assert "docs/explanation/analysis.md" in found.remedy


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="limits of file sizes are POSIX's")
def test_check_sees_space_that_is_free_and_cannot_be_taken(tmp_path):
    """A limit of the process, as a quota is one of the user: the file system's count knows none."""
    program = """
import resource, sys
from pathlib import Path
from slipscale.experiments.running.preflight import PlannedSession, check_folder
resource.setrlimit(resource.RLIMIT_FSIZE, (50_000_000, 50_000_000))
found = check_folder(PlannedSession(study="biet2007", plate="mock", out=Path(sys.argv[1])))
print(found.passed, found.detail, found.remedy)
"""
    done = subprocess.run(
        [sys.executable, "-c", program, tmp_path], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("False")
    assert "writing 100 MB failed (File too large)" in done.stdout
    assert "quota" in done.stdout
    assert list(tmp_path.iterdir()) == []


def test_check_reads_the_study_in_the_language_that_is_asked_for(capsys, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(re.sub(r', fr = "[^"]*"', "", study_text("biet2007")))
    words = ["check", str(path), "--out", str(tmp_path / "data"), "--windowed", "--json"]
    for language, passed in (("en", True), ("fr", False)):
        _, out, _ = run(capsys, *words, "--language", language)
        study = json.loads(out)[0]
        assert study["passed"] is passed
    assert "no words for its options in 'fr'" in study["detail"]


def test_check_of_a_broken_setting_tells_every_fault(capsys, tmp_path, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    small(tmp_path / "data")
    bad = tmp_path / "bad.toml"
    bad.write_text("name = 3")
    words = ["--plate", "mock:fault=not_there@1", "--participant", "01", "--json"]
    status, out, err = run(capsys, "check", str(bad), "--out", str(tmp_path / "data"), *words)
    found = {finding["name"]: finding for finding in json.loads(out)}
    assert status == 1
    assert found["study"]["passed"] is False
    assert found["participant"]["passed"] is False
    assert "study, participant" in err


@pytest.mark.parametrize("required", ["true", "false"])
def test_check_tells_of_noise_that_would_clip_and_where_it_would_not(tmp_path, required):
    path = tmp_path / "loud.toml"

    def sound(level_db):
        text = study_text("biet2007").replace("level_db = -20.0", f"level_db = {level_db}")
        path.write_text(text.replace("required = false", f"required = {required}"))
        planned = PlannedSession(study=str(path), plate="mock", out=tmp_path)
        return next(f for f in check(planned, lambda _: None) if f.name == "sound")

    loud = sound(-3.0)
    assert loud.passed is False
    highest = re.search(r"level_db must be at most (-\d+\.\d), but is -3", loud.detail)[1]
    assert "exceed full scale" not in sound(highest).detail
    assert "exceed full scale" in sound(float(highest) + 0.2).detail


def test_check_refuses_a_label_that_run_would_refuse(tmp_path):
    planned = PlannedSession(study="biet2007", plate="mock", out=tmp_path, participant="../me")
    finding = next(f for f in check(planned, lambda _: None) if f.name == "participant")
    assert finding.passed is False
    assert "letters and digits only" in finding.detail


def test_check_of_a_missing_plate_is_a_finding_with_a_remedy(capsys, tmp_path):
    words = ["--plate", "mock:fault=not_there@1", "--out", str(tmp_path), "--windowed"]
    status, out, _ = run(capsys, "check", *words)
    assert status == 1
    assert "✗ plate" in out
    assert "Check the cable" in " ".join(out.split())


def test_the_installed_command_is_the_front_door():
    done = subprocess.run(
        [Path(sys.executable).with_name("slipscale"), "--version"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == f"slipscale {__version__}\n"


def test_a_session_accepts_a_note_of_every_length_that_the_command_accepts():
    asked = {"token": "a session", "what": "note", "reason": "x" * LONGEST_NOTE}
    assert LiveRequest(**asked).reason == asked["reason"]


@pytest.fixture
def at_home(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.usefixtures("at_home")
@pytest.mark.parametrize(
    "mode, lab, command",
    [
        ("participant", "slipscale.toml", "slipscale next"),
        ("participant", "", "slipscale analyse data"),
        ("pilot", "slipscale.toml", "slipscale analyse data"),
    ],
)
def test_after_a_run_the_terminal_names_the_next_command(record_runs, mode, lab, command):
    if lab:
        Path(lab).write_text('study = "biet2007"\n')
    record_runs(Path("data"), "01", mode=mode)
    said = io.StringIO()
    with redirect_stdout(said):
        assert report_end("complete", next(Path("data").rglob("*_journal.jsonl"))) == 0
    assert said.getvalue().splitlines()[-1] == f"next: {command}"
