"""The plate bench: its pages hold what moves the plate; letting go switches the plate off."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from slipscale.experiments.lab.console import jobs as job_file
from slipscale.experiments.lab.console.actions.calibrating import measured_so_far
from slipscale.experiments.lab.console.jobs import Jobs
from slipscale.experiments.lab.console.page_texts import catalogue
from slipscale.experiments.lab.folder import read_lab
from slipscale.hardware.calibration.record import Gain, Resonance
from slipscale.hardware.calibration.result import Result
from slipscale.hardware.plate_file import Identity
from tests.support.reported_plate import ReportedPlate

PATIENCE_S = 300
TYPED = ("plate", "calibrate", "--plate=mock", "--prompt", "--steps", "--measure-only")
WATCH = ("plate", "watch", "mock", "--amplitude=1", "--every=0.2")
FIT = Resonance(
    frequency_hz=30497.8,
    frequency_ci95_hz=2.3,
    quality_factor=80.1,
    quality_factor_ci95=0.4,
    residual_um=0.01,
)
LINE = Gain(
    um_pp_per_v=0.186,
    um_pp_per_v_ci95=0.001,
    residual_um=0.01,
    voltage_max_v=16.0,
    amplitude_max_um_pp=2.98,
)
RESULT = Result(
    resonance=FIT, gain=LINE, voltage_convention="V peak", file=Path("c-1.toml")
).model_dump_json()
ASKED = {"by": "Ada", "instrument": "LDV"}


def within(seconds, reached):
    end_s = time.monotonic() + seconds
    while not reached() and time.monotonic() < end_s:
        time.sleep(0.05)
    return reached()


def said(visitor, kind, output, *, status=0, steps=(), running=False):
    """Have a job of the bench have said something."""
    place = visitor.console.jobs
    path = SimpleNamespace(stat=lambda: SimpleNamespace(st_mtime_ns=1))
    place.jobs[kind] = SimpleNamespace(
        running=running,
        status=None if running else status,
        released=False,
        output=path,
        said=lambda: output,
        complained=lambda: "the board does not answer",
        steps=lambda: list(steps),
        hold=lambda: None,
        about=kind,
    )


def test_the_page_shows_limits_and_calibration_without_connecting_the_plate(visitor, lab, words_of):
    page = words_of(visitor.see("/bench"))  # serial:COM9 does not exist
    assert "largest level 2.5 µm p-p" in page
    assert "No calibration" in page
    (lab / "slipscale.toml").write_text('plate = "serial:COM9,calibration=none.toml"\n')
    visitor.console.state.now(fresh=True)
    assert "none.toml" in words_of(visitor.see("/bench"))


def test_each_action_starts_the_plates_own_command(visitor, lab):
    (lab / "calibration-1.toml").write_text("")
    assert visitor.ask("surface", level=1.2)[0] == 200
    assert visitor.ask("conform")[0] == 200
    assert visitor.ask("calibrate", temperature="22,5", finger=True, **ASKED)[0] == 200
    assert visitor.ask("calibrate", keep=False, table="none.csv", **ASKED)[0] == 409
    (lab / "read.csv").write_text("")
    assert visitor.ask("calibrate", keep=False, table="read.csv", serial="7", **ASKED)[0] == 200
    by_hand = {"table": "typed", "keep": False, "centre": "25000,5"}
    assert visitor.ask("calibrate", **by_hand, **ASKED)[0] == 200
    calibrate = ("calibrate", "plate", "calibrate", "--plate=serial:COM9", "--by=Ada")
    measured = ("--instrument=LDV", "--temperature=22.5", "--finger")
    typed = ("--instrument=LDV", "--centre=25000.5", "--prompt")
    read = ("--instrument=LDV", "--csv=read.csv", "--serial=7")
    assert visitor.jobs.started == [
        ("surface", "plate", "watch", "serial:COM9", "--amplitude=1.2", "--every=0.2"),
        ("conform", "plate", "conform", "serial:COM9"),
        (*calibrate, *measured, "--out", "calibration-2.toml", "--steps", "--json"),
        (*calibrate, *read, "--measure-only", "--steps", "--json"),
        (*calibrate, *typed, "--measure-only", "--steps", "--json"),
    ]


def test_nothing_else_moves_the_plate_while_the_bench_does(visitor):
    said(visitor, "surface", "", running=True)
    for action in ("conform", "check"):
        status, told = visitor.ask(action)
        assert (status, "still" in told) == (409, True)


def test_what_a_calibration_measured_is_plotted_and_its_file_is_used(visitor, lab, words_of):
    steps = [f"{30000 + n} 5 {n / 100}" for n in range(124)] + ["30500 8 1.5", "30500 16 3"]
    said(visitor, "calibrate", "", steps=steps, running=True)
    page = visitor.see("/bench")
    assert '<progress max="148" value="126"' in page
    resonance, gain = re.findall(r'(?s)<svg viewBox="0 0 640 180".*?</svg>', page)
    assert (resonance.count("<circle"), gain.count("<circle")) == (124, 2)
    assert 'cx="630.0" cy="10.0"' in gain  # 3 µm at 16 V is the frame's corner
    assert visitor.ask("adopt")[0] == 409
    said(visitor, "calibrate", f"1 Hz: type in µm peak to peak: \n{RESULT}\n")
    page = words_of(visitor.see("/bench"))
    assert "Use this calibration" in page
    assert "resonance 30497.8 ± 2.3 Hz" in page
    assert "range 0 to 2.980 µm p-p (16 V peak)" in page
    assert "1 Hz: type" not in page
    page = words_of(visitor.see("/bench", **{"accept-language": "fr"}))
    assert "résonance 30497,8 ± 2,3 Hz" in page
    assert "gain 0,18600 ± 0,00100 µm crête à crête par V crête" in page
    assert "0 à 2,980 µm crête à crête (16 V crête)" in page
    assert visitor.ask("adopt")[0] == 200
    assert read_lab(lab).plate == "serial:COM9,calibration=c-1.toml"


def test_an_instruments_readings_are_typed_point_by_point(visitor, words_of):
    typed = []
    said(visitor, "calibrate", "", steps=["30000 5 ?", "30000 5 0.1", "30075 5 ?"], running=True)
    visitor.jobs.jobs["calibrate"].type = typed.append
    page = words_of(visitor.see("/bench"))
    assert "vibrates at 30075.0 Hz and 5.00 V peak" in page
    assert "Point 2 of 148" in page
    assert "Repeat the previous point" in page
    assert visitor.ask("reading", reading="0,25", number=0)[0] == 409  # sent twice
    assert visitor.ask("reading", reading="much", number=1)[0] == 409
    for reading in ("0,25", "b"):
        assert visitor.ask("reading", reading=reading, number=1)[0] == 200
    assert typed == ["0,25", "b"]
    said(visitor, "calibrate", "", steps=["30000 5 ?"], running=True)
    assert "Repeat the previous point" not in words_of(visitor.see("/bench"))
    said(visitor, "calibrate", "", steps=["30000 5 ?", "30000 5 0.1"], running=True)
    assert re.search('id="reading-typed"[^>]* readonly>', visitor.see("/bench"))  # keeps the focus
    said(visitor, "calibrate", "", steps=["30000 5 ?"], status=3)
    assert "vibrates at" not in words_of(visitor.see("/bench"))
    assert visitor.ask("reading", reading="1", number=0)[0] == 409


def test_verdicts_readings_and_failures_are_shown(visitor, words_of):
    said(
        visitor,
        "conform",
        '["conforms", "answers ID", ""]\n["departs", "stops", "too late"]\n2 rules, 1 violated\n',
        status=1,
    )
    said(
        visitor,
        "surface",
        "time s\n   0.1    1.200   ##|  measured\n   0.3    1.180   ##|  measured\n",
        running=True,
    )
    page = words_of(visitor.see("/bench"))
    assert "conforms answers ID" in page
    assert "violated stops too late" in page
    assert "1.180" in page
    for kind in ("surface", "emulator"):
        said(visitor, kind, "", status=3)
        assert words_of(visitor.see("/bench")).count("the board does not answer") == 1
        said(visitor, kind, "")


def test_a_job_of_the_bench_ends_when_no_page_holds_it_any_more(lab, monkeypatch):
    monkeypatch.setattr(job_file, "HOLD_S", 2.0 * PATIENCE_S)
    job = Jobs(lab).start("calibrate", "the calibration", *TYPED, "--by=A", "--instrument=B")
    for answer in ("much", "0,25", "b"):
        assert within(PATIENCE_S, lambda: job.hold() or measured_so_far(job.steps()).asked)
        assert job.running
        job.type(answer)
    assert within(PATIENCE_S, lambda: job.hold() or any(" b" in step for step in job.steps()))
    assert job.running
    monkeypatch.setattr(job_file, "HOLD_S", 0.0)  # nobody renews the hold any more
    assert within(PATIENCE_S, lambda: not job.running)
    assert job.released
    assert job.status != -signal.SIGKILL


@pytest.mark.skipif(sys.platform == "win32", reason="kills as POSIX does")
def test_a_job_of_the_bench_ends_when_the_console_is_killed(lab, tmp_path_factory):
    """The process has ended, too: nothing switches the plate on again."""
    reported = ReportedPlate(tmp_path_factory.mktemp("reported"))
    words = ("surface", "the surface", "plate", "watch", reported.spec, *WATCH[3:])
    start = f"Jobs(Path()).start(*{words!r}); time.sleep({PATIENCE_S})"
    imports = "import time; from pathlib import Path; from slipscale.experiments.lab.console.jobs"
    command = [sys.executable, "-c", f"{imports} import Jobs; {start}"]
    with subprocess.Popen(command, env=os.environ | reported.environment) as console:
        try:
            assert within(PATIENCE_S, reported.vibrates)
        finally:
            console.kill()
    assert within(PATIENCE_S, lambda: not reported.vibrates())
    assert within(PATIENCE_S, lambda: not running(reported.spec))


def running(spec):
    """Return whether a process has the plate's SPEC among its arguments."""
    listed = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True)
    return any("watch" in line and spec in line for line in listed.stdout.splitlines())


@pytest.mark.parametrize("language", ["en", "fr"])
@pytest.mark.parametrize("field", Identity.model_fields)
def test_every_part_of_a_plates_identity_has_its_own_label(language, field):
    labels = catalogue(language).texts
    assert labels[f"bench.identity_{field}"] != labels["bench.serial"]
