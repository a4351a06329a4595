"""A session with a person: what is refused before anything moves, and what is said at its end."""

import os
import subprocess
import sys

import pytest

from experiments.journal.journal import Journal
from experiments.journal.run_record import read_plan
from experiments.participants.base import StopRequested
from experiments.participants.scripted import ScriptedParticipant
from experiments.running import lab_session, preflight
from experiments.running.lab_session import Setting, begin, go_on, make_plan
from experiments.running.preflight import PlannedSession, check_participant, check_plate
from faults import UserError
from hardware import address
from hardware.clock import VirtualClock
from hardware.errors import PlateFault
from hardware.limits import PlateLimits
from slipscale import main

SETTING = Setting(plate="mock")


@pytest.fixture
def window(monkeypatch):
    """Put somebody in the window's place; return the list of what they answer."""
    script = []

    def sit_down(*, clock, **_):
        return ScriptedParticipant(script, clock, step_s=0.0)

    monkeypatch.setattr(lab_session, "PsychoPyWindow", sit_down)
    monkeypatch.setattr(lab_session, "check_device", lambda: "no headphones")
    return script


@pytest.fixture
def no_window(monkeypatch):
    """Fail where a window opens."""

    def refuse(**_):
        pytest.fail("the window opened")

    monkeypatch.setattr(lab_session, "PsychoPyWindow", refuse)
    monkeypatch.setattr(lab_session, "check_device", lambda: "no headphones")


def a_plan(*, pilot=True, **changes):
    return make_plan("biet2007", participant="01", pilot=pilot, **changes)


def stopped(folder, window, *, plan=None, setting=SETTING):
    """Leave an interrupted run in a folder; return its journal's path."""
    plan = plan or a_plan()
    window[:] = [StopRequested("tired")]
    assert begin(folder, plan, setting) == "stopped"
    return plan.journal_path(folder)


def test_a_folder_that_cannot_be_written_is_told_before_the_window_opens(no_window, tmp_path):
    (tmp_path / "data").write_text("a file, not a folder")
    with pytest.raises(UserError, match=r"journal .*data"):
        begin(tmp_path / "data", a_plan(), SETTING)


def test_a_second_session_of_the_same_run_is_refused_before_the_plate_moves(no_window, tmp_path):
    plan = a_plan()
    with (
        Journal.create(plan.journal_path(tmp_path), VirtualClock()),
        pytest.raises(UserError, match=r"already \(running now\).*end it where it runs"),
    ):
        begin(tmp_path, plan, SETTING)


def test_a_run_that_another_process_writes_is_running_and_not_interrupted(window, tmp_path, capsys):
    path = stopped(tmp_path, window)
    words = ["--participant", "01", "--out", str(tmp_path)]
    writer = "import sys, time; from pathlib import Path\n"
    writer += "from experiments.journal.journal import Journal\n"
    writer += "from hardware.clock import SystemClock\n"
    writer += "journal = Journal.reopen(Path(sys.argv[1]), SystemClock())\n"
    writer += "print('locked', flush=True); time.sleep(60)"
    other = subprocess.Popen([sys.executable, "-c", writer, path], stdout=subprocess.PIPE)
    with other:
        assert other.stdout.readline() == b"locked\n"
        assert main(["run", *words]) == 2
        said = capsys.readouterr().err
        assert "running now" in said
        assert "resume" not in said
        found = check_participant(
            PlannedSession(study="", plate="mock", out=tmp_path, participant="01")
        )
        assert (found.passed, "running now" in found.detail) == (False, True)
        assert main(["resume", str(path)]) == 2
        assert "another session is writing it" in capsys.readouterr().err
        other.kill()
    assert main(["run", *words]) == 2
    assert f"interrupted): {path}; To go on: slipscale resume {path}" in capsys.readouterr().err


def test_a_plate_that_is_not_there_leaves_no_trace_of_the_participant(no_window, tmp_path):
    with pytest.raises(PlateFault):
        begin(tmp_path, a_plan(), Setting(plate="mock:fault=not_there@1"))
    assert list((tmp_path / "sourcedata").iterdir()) == []


def test_a_surface_beyond_this_plate_is_told_before_anybody_sits_down(
    no_window, tmp_path, monkeypatch
):
    """The study keeps its own [plate]; a calibration or a board may allow less."""
    study = tmp_path / "study.toml"
    tasks = 'protocol = "magnitude_estimation"\nstandard_um_pp = 2.0\nmodulus = 10'
    study.write_text(f'name = "s"\ntitle = "S"\namplitudes_um_pp = [0, 1]\n[[tasks]]\n{tasks}\n')
    monkeypatch.setattr(address, "PlateLimits", lambda: PlateLimits(amplitude_um_pp=1.5))
    plan = make_plan(str(study), participant="01", pilot=True)
    with pytest.raises(PlateFault, match=r"amplitude 2 µm p-p is outside 0 to 1\.5"):
        begin(tmp_path, plan, SETTING)
    with pytest.raises(PlateFault, match=r"amplitude 2 µm p-p is outside 0 to 1\.5"):
        check_plate(PlannedSession(study=str(study), plate="mock", out=tmp_path))
    assert not plan.journal_path(tmp_path).exists()


def test_a_label_that_means_the_same_as_one_there_is_refused(window, tmp_path):
    stopped(tmp_path, window)
    for alike in ("1", "001"):
        plan = make_plan("biet2007", participant=alike, pilot=True)
        with pytest.raises(UserError, match=f"{alike}: there is a participant 01 already"):
            begin(tmp_path, plan, SETTING)
        with pytest.raises(UserError, match="there is a participant 01 already"):
            check_participant(
                PlannedSession(study="", plate="mock", out=tmp_path, participant=alike)
            )
    found = check_participant(PlannedSession(study="", plate="mock", out=tmp_path))
    assert "next free: 02" in found.detail


@pytest.mark.parametrize("noise_um, noisy", [(0.005, False), (0.02, True)])
def test_check_tells_of_a_sensor_too_noisy_for_a_session(tmp_path, monkeypatch, noise_um, noisy):
    monkeypatch.setattr(preflight, "SystemClock", VirtualClock)  # noise follows from seed and time
    found = check_plate(
        PlannedSession(study="biet2007", plate=f"mock:noise={noise_um}", out=tmp_path)
    )
    assert found.passed is (None if noisy else True)
    assert ("readings scatter by 0.0" in found.remedy) == noisy


def test_a_stopped_session_leaves_a_data_set_and_can_go_on(window, tmp_path):
    path = stopped(tmp_path, window)
    assert (tmp_path / "participants.tsv").exists()
    window[:] = [StopRequested("still tired")]
    assert go_on(path, SETTING) == "stopped"
    assert [r.kind for r in read_plan(path)[1]].count("stop") == 2


def test_an_error_is_told_with_how_to_go_on_and_is_not_hidden(window, tmp_path, capsys):
    window[:] = [KeyboardInterrupt()]
    plan = a_plan()
    # A data set that cannot be built must not hide why the session ended.
    (tmp_path / "participants.tsv").mkdir(parents=True)
    with pytest.raises(KeyboardInterrupt):
        begin(tmp_path, plan, SETTING)
    said = capsys.readouterr().err
    assert "the data set was not built" in said
    assert f"slipscale resume {plan.journal_path(tmp_path)}" in said


def test_a_participants_run_never_goes_on_with_a_plate_that_nobody_feels(
    window, tmp_path, monkeypatch
):
    path = stopped(tmp_path, window, plan=a_plan(pilot=False))
    with pytest.raises(UserError, match="a participant's run cannot go on"):
        go_on(path, SETTING)


def test_resume_takes_the_plate_that_the_run_was_on(window, tmp_path, monkeypatch, capsys):
    path = stopped(tmp_path, window, setting=Setting(plate="mock:noise=0"))
    taken = []
    monkeypatch.setattr(
        lab_session, "go_on", lambda _, setting: taken.append(setting.plate) or "complete"
    )
    assert main(["resume", str(path)]) == 0
    assert main(["resume", str(path), "--plate", "mock"]) == 0
    assert taken == ["mock:noise=0", "mock"]


def test_a_journal_that_was_renamed_or_moved_is_refused(window, tmp_path, capsys):
    path = stopped(tmp_path / "data", window)
    for place in (tmp_path / path.name, path.with_name("sub-02_run-01_journal.jsonl")):
        place.write_bytes(path.read_bytes())
        assert main(["resume", str(place)]) == 2
        assert "put it back" in capsys.readouterr().err


@pytest.mark.skipif(
    sys.platform == "win32" or os.geteuid() == 0, reason="needs rights that can be missing"
)
def test_a_folder_without_permission_is_one_sentence(no_window, tmp_path, capsys):
    (tmp_path / "data").mkdir(mode=0o500)
    assert main(["run", "--participant", "01", "--out", str(tmp_path / "data")]) == 2
    assert "Permission denied" in capsys.readouterr().err
