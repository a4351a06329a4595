"""A session with a person: what is refused before anything moves, and what is said at its end."""

import dis
import os
import signal
import subprocess
import sys
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import pytest

from slipscale.commands import main
from slipscale.experiments.journal import journal as journal_module
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.journal.locks import is_being_written
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.participants.base import StopRequested
from slipscale.experiments.running import lab_session, preflight
from slipscale.experiments.running.lab_session import Setting, begin, go_on, make_plan
from slipscale.experiments.running.preflight import PlannedSession, check_participant, check_plate
from slipscale.experiments.running.preflight import check_folder as whole_check_folder
from slipscale.experiments.running.run_state import not_built, studies
from slipscale.experiments.session.mailbox import Mailbox
from slipscale.faults import UserError
from slipscale.hardware import address
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.clock import SystemClock, VirtualClock
from slipscale.hardware.contact.emulated_line import EmulatedLine
from slipscale.hardware.errors import PlateFault
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.signals import EndedBySignal
from tests.support.scripted import ScriptedParticipant

SETTING = Setting(plate="mock")


def check_folder(planned):
    """Return what a whole checklist says of the folder."""
    try:
        return whole_check_folder(planned)
    except UserError as error:
        return preflight.Finding(name="folder", passed=False, detail=str(error), remedy="")


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
        pytest.raises(UserError, match=r"already has a run \(running now\).*end it there"),
    ):
        begin(tmp_path, plan, SETTING)


def test_a_run_that_another_process_writes_is_running_and_not_interrupted(window, tmp_path, capsys):
    path = stopped(tmp_path, window)
    words = ["--participant", "01", "--out", str(tmp_path)]
    writer = "import sys, time; from pathlib import Path\n"
    writer += "from slipscale.experiments.journal.journal import Journal\n"
    writer += "from slipscale.hardware.clock import SystemClock\n"
    writer += "journal = Journal.reopen(Path(sys.argv[1]), SystemClock())\n"
    writer += "print('locked', flush=True); time.sleep(3600)"
    other = subprocess.Popen([sys.executable, "-c", writer, path], stdout=subprocess.PIPE)
    with other, ExitStack() as ending:
        ending.callback(other.kill)
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
        assert "another session is writing to it" in capsys.readouterr().err
    assert main(["run", *words]) == 2
    assert f"interrupted): {path}; To continue: slipscale resume {path}" in capsys.readouterr().err


def signalled(frame):
    """Return whether Python can run a signal's handler at a line: not where it does nothing."""
    return frame.f_code.co_code[frame.f_lasti] != dis.opmap["NOP"]


def test_a_signal_at_any_line_between_lock_and_equipment_leaves_no_lock(tmp_path, monkeypatch):
    """The error is kept, as libraries keep it: with it, Python keeps each function's variables."""
    monkeypatch.setattr(lab_session, "_perform", lambda *_: sys.settrace(None))
    files = (journal_module.__file__, lab_session.__file__)
    plan, lines, last = make_plan("biet2007", participant="01"), [], 0
    while len(lines) == last:  # the signal arrives one line later each time

        def trace(frame, event, _, lines=lines, seen=[0]):  # noqa: B006 - counts this round
            if frame.f_code.co_filename not in files:
                return None
            if event == "line" and signalled(frame):
                seen[0] += 1
                if seen[0] > len(lines):
                    lines.append(f"{frame.f_code.co_qualname}, line {frame.f_lineno}")
                    raise EndedBySignal
            return trace

        last += 1
        sys.settrace(trace)
        kept = None
        try:
            begin(tmp_path, plan, SETTING)
        except EndedBySignal as error:
            kept = error
        sys.settrace(None)
        assert not is_being_written(plan.journal_path(tmp_path)), (lines[-1], kept)
    assert any(line.startswith("Journal._open,") for line in lines)


@pytest.mark.parametrize("place", ["tell", "__enter__"])
def test_a_signal_while_the_mailbox_opens_leaves_neither_mailbox_nor_lock(
    window, tmp_path, monkeypatch, place
):
    path = stopped(tmp_path, window)
    opens = getattr(Mailbox, place)

    def interrupted(mailbox, *words):
        opens(mailbox, *words)
        raise EndedBySignal("SIGTERM")

    monkeypatch.setattr(Mailbox, place, interrupted)
    with pytest.raises(EndedBySignal):
        go_on(path, SETTING)
    assert [found.name for found in path.parent.iterdir()] == [path.name]


def test_a_signal_after_a_session_still_closes_plate_and_journal(window, tmp_path, monkeypatch):
    path = stopped(tmp_path, window)
    closed, plates = MockPlate.close, []

    class Interrupted(ExitStack):
        def __exit__(self, *error):
            signal.raise_signal(signal.SIGTERM)
            return super().__exit__(*error)

    def close(plate):
        plates.append(closed(plate))

    monkeypatch.setattr(lab_session, "ExitStack", Interrupted)
    monkeypatch.setattr(MockPlate, "close", close)
    window[:] = [StopRequested("tired")]
    with pytest.raises(EndedBySignal):
        go_on(path, SETTING)
    assert plates
    assert not is_being_written(path)
    assert not list(path.parent.glob("*.l*k"))


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
    monkeypatch.setattr(address, "Plate", partial(address.Plate, limits=PlateLimits(level=1.5)))
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
        with pytest.raises(UserError, match=f"{alike}: .* already has a participant 01"):
            begin(tmp_path, plan, SETTING)
        with pytest.raises(UserError, match="already has a participant 01"):
            check_participant(
                PlannedSession(study="", plate="mock", out=tmp_path, participant=alike)
            )
    found = check_participant(PlannedSession(study="", plate="mock", out=tmp_path))
    assert "next free label is 02" in found.detail


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
    with monkeypatch.context() as real:
        real.setattr(MockPlate, "simulated", False)
        path = stopped(tmp_path, window, plan=a_plan(pilot=False))
    with pytest.raises(UserError, match="a participant's run cannot be resumed"):
        go_on(path, SETTING)


@pytest.mark.usefixtures("patient")
def test_a_participants_run_on_an_emulated_board_is_refused_with_its_remedy(
    no_window, tmp_path, emulate
):
    board = emulate()
    setting = Setting(plate=f"serial:{board.port}")
    with pytest.raises(UserError, match=r"EMULATED-1: the plate is simulated.*add --pilot"):
        begin(tmp_path, a_plan(pilot=False), setting)
    assert list((tmp_path / "sourcedata").iterdir()) == []


@pytest.mark.usefixtures("patient")
def test_a_rehearsal_on_an_emulated_board_is_a_pilot(window, tmp_path, emulate):
    board = emulate()
    path = stopped(tmp_path, window, setting=Setting(plate=f"serial:{board.port}"))
    assert read_plan(path)[0].mode == "pilot"


def test_another_study_does_not_come_into_a_folder_unnoticed(window, tmp_path):
    stopped(tmp_path, window)
    other = make_plan("textures_demo", participant="02", pilot=True)
    with pytest.raises(UserError, match=r"contains the study biet2007.*--add-study"):
        begin(tmp_path, other, SETTING)
    found = check_folder(PlannedSession(study="textures_demo", plate="mock", out=tmp_path))
    assert (found.passed, "--add-study" in found.remedy) == (None, True)


def test_another_study_comes_into_a_folder_where_it_is_said(window, tmp_path):
    stopped(tmp_path, window)
    other = make_plan("textures_demo", participant="02", pilot=True)
    window[:] = [StopRequested("tired")]
    assert begin(tmp_path, other, SETTING, add_study=True) == "stopped"
    assert studies(tmp_path) == ["biet2007", "textures_demo"]


def test_pilots_and_participants_lie_apart_unless_a_folder_is_named(window, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    window[:] = [StopRequested("tired")]
    assert main(["run", "--participant", "01"]) == 130
    assert studies(tmp_path / "pilots/rehearsals") == ["biet2007"]
    assert not (tmp_path / "data").exists()


def test_a_pilot_among_participants_is_refused_with_both_ways_out(window, tmp_path, monkeypatch):
    stopped(tmp_path, window)
    with pytest.raises(UserError, match=r"contains pilot data.*--out data\), or.*add --pilot"):
        begin(tmp_path, a_plan(pilot=False), SETTING)


def test_at_its_end_a_run_is_copied_and_the_copy_compared(window, tmp_path, capsys):
    (tmp_path / "disk").mkdir()
    setting = Setting(plate="mock", backup=tmp_path / "disk")
    path = stopped(tmp_path / "data", window, setting=setting)
    copy = tmp_path / "disk/data" / path.relative_to(tmp_path / "data")
    assert copy.read_bytes() == path.read_bytes()
    assert f"backup: {copy}" in capsys.readouterr().err


def test_a_backup_that_is_not_there_costs_nothing_but_is_said_aloud(window, tmp_path, capsys):
    setting = Setting(plate="mock", backup=tmp_path / "unplugged")
    path = stopped(tmp_path / "data", window, setting=setting)
    first, *_, last = capsys.readouterr().err.splitlines()
    assert first.startswith("NO BACKUP of this run unless you correct this: --backup")
    assert last.startswith("NO BACKUP of this run: --backup")
    assert read_plan(path)[1][-1].kind == "stop"
    found = check_folder(
        PlannedSession(study="biet2007", plate="mock", out=tmp_path, backup=setting.backup)
    )
    assert found.passed is False


def test_a_run_that_goes_on_is_copied_to_the_same_folder(window, tmp_path):
    (tmp_path / "disk").mkdir()
    backup = replace(SETTING, backup=tmp_path / "disk")
    path = stopped(tmp_path / "data", window, setting=backup)
    window[:] = [StopRequested("still tired")]
    go_on(path, SETTING)
    copy = tmp_path / "disk/data" / path.relative_to(tmp_path / "data")
    assert copy.read_bytes() == path.read_bytes()


def test_a_disk_that_is_full_at_the_end_names_the_command_that_writes_the_tables(
    window, tmp_path, monkeypatch
):
    def full(_dataset):
        raise UserError("participants.tsv: cannot be written (No space left on device)")

    monkeypatch.setattr(lab_session, "build_dataset", full)
    expected = r"was stopped and all answers so far are saved in .*: slipscale data build.*resume"
    with pytest.raises(UserError, match=expected):
        stopped(tmp_path / "data", window)


def test_tables_that_cannot_be_written_leave_a_complete_run_complete(
    laboratory, plan, monkeypatch, tmp_path
):
    laboratory.run()
    path = plan().journal_path(tmp_path)
    with Journal.reopen(path, VirtualClock()) as journal:
        said = not_built(UserError("full"), tmp_path, journal)
    assert said.startswith(f"full. The run is complete and all answers are saved in {path}. ")
    assert "resume" not in said


def test_the_operator_is_shown_the_notes_on_the_plate(window, tmp_path, monkeypatch, capsys):
    note = "the calibration is 300 days old"
    monkeypatch.setattr(MockPlate, "_check_identity", lambda *_: (note,))
    shown = []
    whole = lab_session.run_plan
    monkeypatch.setattr(
        lab_session,
        "run_plan",
        lambda plan, setup, **rest: shown.extend(setup.warnings) or whole(plan, setup, **rest),
    )
    stopped(tmp_path, window)
    assert shown == [note]
    assert note in capsys.readouterr().err


def test_a_complete_run_is_not_gone_on_with_and_its_answers_are_said_to_be_safe(
    tmp_path, laboratory, plan
):
    laboratory.run()
    with pytest.raises(UserError, match=r"complete and all its answers are saved.*data build"):
        go_on(plan().journal_path(tmp_path), SETTING)


def test_the_laboratory_can_require_sound_where_the_study_does_not(no_window, tmp_path):
    setting = Setting(plate="mock", sound_required=True)
    with pytest.raises(UserError, match="required by the laboratory folder: no headphones"):
        begin(tmp_path, a_plan(), setting)


def test_the_operator_sees_whose_session_on_which_plate_it_is():
    assert a_plan().heading("mock") == (
        "participant 01, run 01",
        "study biet2007",
        "plate mock",
        "PILOT",
    )


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
        assert "restore that name" in capsys.readouterr().err


@pytest.mark.skipif(
    sys.platform == "win32" or os.geteuid() == 0, reason="needs rights that can be missing"
)
def test_a_folder_without_permission_is_one_sentence(no_window, tmp_path, capsys):
    (tmp_path / "data").mkdir(mode=0o500)
    assert main(["run", "--participant", "01", "--out", str(tmp_path / "data")]) == 2
    assert "Permission denied" in capsys.readouterr().err


# Resonance tracking ---------------------------------------------------------------------------

TRACKED = """
name = "tracked"
title = "Tracked"
amplitudes_um_pp = [0.0, 1.2]

[plate]
track_resonance = "vibrometer:PORT,amplitude_scale=0.5"
track_every_s = 30.0

[[tasks]]
protocol = "magnitude_estimation"
repetitions = 1
practice = 0
"""


def tracking_of(tmp_path, plate, port="COM3", spec="vibrometer:"):
    path = tmp_path / "tracked.toml"
    text = TRACKED.replace("PORT", port).replace("vibrometer:", spec)
    path.write_text(text, encoding="utf-8")
    plan = make_plan(str(path), participant="01", pilot=True)
    with ExitStack() as stack:
        return lab_session._tracking(plan, plate, SystemClock(), stack)


def test_a_simulated_plate_needs_no_tracking_and_one_that_follows_by_itself_refuses_it(tmp_path):
    assert tracking_of(tmp_path, SimpleNamespace(simulated=True, tracks=False)) is None
    board = SimpleNamespace(simulated=False, tracks=False, name="serial")
    with pytest.raises(UserError, match="backend 'serial' follows its resonance automatically"):
        tracking_of(tmp_path, board)


@pytest.mark.usefixtures("patient")
def test_tracking_reads_the_vibrometer_that_the_study_names(tmp_path):
    generator = SimpleNamespace(simulated=False, tracks=True, name="scpi")
    with EmulatedLine(lambda _: b"2.4\n") as line:
        found = tracking_of(tmp_path, generator, line.port)
    assert found._every_s == 30.0
    assert found._vibrometer._samples[0].values == (1.2,)
    with pytest.raises(UserError, match="expected vibrometer:PORT"):
        tracking_of(tmp_path, generator, spec="lasers:")
