"""What tests of several packages need: a screen, emulated boards."""

from __future__ import annotations

import gc
import os
import pickle
import shutil
import subprocess
import sys
from contextlib import ExitStack, contextmanager
from datetime import date
from functools import cache

import portalocker
import pytest
from hypothesis import settings

from tests.support.emulator_process import EmulatorProcess
from tests.support.workers import memory_bytes, workers

# Nothing is timed in a test: on a busy machine a deadline fails for no fault of the code.
settings.register_profile("slipscale", deadline=None, max_examples=15)
# More than every run needs: python -m pytest --hypothesis-profile=campaign
settings.register_profile("campaign", deadline=None, max_examples=1000)
settings.load_profile("slipscale")
# Read at the first import of NumPy or SciPy, also in the processes that tests start. On matrices
# as small as ours a second thread only waits, at full load: L-BFGS-B takes eight times the CPU.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Windows are drawn in software: its threads wait for each other at full load, too.
os.environ.setdefault("LP_NUM_THREADS", "0")
# jsonschema compiles 38 grammars for a format that no test checks: seconds per process.
sys.modules.setdefault("rfc3987_syntax", None)
# Nothing that collection loads is ever garbage: it is neither searched now nor in each test.
gc.disable()


def pytest_collection_finish():
    """Collect garbage from here on, of what tests allocate, but not after every 700 objects."""
    gc.freeze()
    gc.set_threshold(50_000)
    gc.enable()


def pytest_xdist_auto_num_workers():
    """Run as many workers as there are processors, unless the memory is too small for them."""
    return workers(os.cpu_count() or 1, memory_bytes())


@pytest.fixture(scope="session", autouse=True)
def _no_waiting_for_the_disk():
    """No machine loses its power in a test; tests of what reaches the disk replace this."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", lambda _descriptor: None)
        yield


@pytest.fixture(scope="session", autouse=True)
def _own_runtime_folder(tmp_path_factory):
    """Lock instruments per process of pytest-xdist: emulated ones have the same names in each."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_RUNTIME_DIR", str(tmp_path_factory.mktemp("runtime")))
        yield


@pytest.fixture(scope="session")
def display():
    """Give the tests a display of their own: key presses never reach a developer's desktop.

    On Linux that is an Xvfb with a number that it picks itself, so that each pytest-xdist worker
    has one; elsewhere the machine's own.
    """
    if not sys.platform.startswith("linux"):
        yield None
        return
    if not shutil.which("Xvfb"):
        pytest.fail("Xvfb is missing: run python3 tools/system_packages.py")
    reading, writing = os.pipe()
    # The server outlives the tests and goes when this process does: Xlib ends a process whose
    # server dies first. Keys do not repeat (-r), however late xdotool releases them.
    xvfb = ["Xvfb", "-displayfd", str(writing), "-screen", "0", "1280x800x24", "-r"]
    # Without -noreset, it restarts when its last client leaves, and refuses those that come then.
    xvfb += ["-nolisten", "tcp", "-noreset"]
    server = subprocess.Popen(
        ["setpriv", "--pdeathsig", "TERM", *xvfb],
        pass_fds=[writing],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(writing)
    with os.fdopen(reading) as answer:
        number = answer.readline().strip()
    if not number:
        pytest.fail(f"Xvfb did not start (status {server.wait()})")
    server.returncode = 0  # nobody waits for it: it goes after this process
    before = os.environ.get("DISPLAY")
    os.environ["DISPLAY"] = f":{number}"
    yield f":{number}"
    if before is None:
        del os.environ["DISPLAY"]
    else:
        os.environ["DISPLAY"] = before


@pytest.fixture
def emulate():
    """Start emulated boards, each in its own process; all end with the test."""
    with ExitStack() as stack:
        yield lambda *arguments: stack.enter_context(EmulatorProcess(*arguments))


@pytest.fixture
def host(monkeypatch):
    """Let drivers and commands run on a computer in virtual time, to which boards can be connected.

    ``host.plug_in(...)`` has the arguments of ``slipscale plate emulate``.
    """
    from tests.support.virtual_time import VirtualHost

    host = VirtualHost()
    monkeypatch.setattr("slipscale.hardware.backends.serial_board.host.SystemHost", lambda: host)
    monkeypatch.setattr("slipscale.hardware.clock.SystemClock", lambda: host)
    return host


@pytest.fixture
def patient(monkeypatch):
    """Let sessions wait a minute for a board or a sensor, which a busy machine can keep waiting."""
    monkeypatch.setattr("slipscale.hardware.backends.serial_board.link.REPLY_TIMEOUT_S", 60.0)
    monkeypatch.setattr("slipscale.hardware.backends.serial_board.link.GREETING_S", 60.0)
    monkeypatch.setattr("slipscale.hardware.output.state.GuardedOutput.frozen_s", 60.0)
    monkeypatch.setattr("slipscale.hardware.contact.serial_columns.FIRST_S", 60.0)
    monkeypatch.setattr("slipscale.hardware.contact.serial_columns.SILENT_S", 60.0)


@contextmanager
def _without_simulated_fits():
    """Leave out goodness of fit, from 1,000 simulated data sets per threshold."""
    from slipscale.analysis.statistics.not_computed import NotComputed

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "slipscale.analysis.tasks.thresholds.statistics.goodness_of_fit",
            lambda *_, **__: NotComputed("left out of this test"),
        )
        yield


@pytest.fixture(scope="module")
def without_simulated_fits():
    """Leave out what takes most of a threshold's time, for modules about something else."""
    with _without_simulated_fits():
        yield


@pytest.fixture(scope="session")
def made_once(tmp_path_factory):
    """Return a function that has a folder made, by the first process that needs it.

    The processes of pytest-xdist share the folder. A test copies it before it writes into it.
    """
    base = tmp_path_factory.getbasetemp()
    shared = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "made_once"
    shared.mkdir(exist_ok=True)

    def folder(name, make):
        done = shared / f"{name}.done"
        with portalocker.Lock(shared / f"{name}.lock", timeout=600):
            if not done.exists():
                make(shared / name)
                done.touch()
        return shared / name

    return folder


@pytest.fixture(scope="session")
def shipped_pilot(made_once):
    """Return a function from a shipped study's name to its pilot's data set and analysis.

    Four people, seed 1, no simulated fits.
    """
    from slipscale.analysis.pipeline import analyse
    from slipscale.experiments.running.pilot import pilot_plans, run_pilot

    @cache
    def made(study):
        def pilot(folder):
            plans = pilot_plans(study, participants=4, seed=1, language=None)
            run_pilot(folder / "data", plans, tell=lambda _: None)
            with _without_simulated_fits():
                (folder / "analysis").write_bytes(pickle.dumps(analyse(folder / "data")))

        folder = made_once(study, pilot)
        return folder / "data", pickle.loads((folder / "analysis").read_bytes())  # noqa: S301 - written here

    return made


@contextmanager
def _without_figures():
    """Leave out the figures of reports."""
    from matplotlib.figure import Figure

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "slipscale.analysis.reporting.files.draw", lambda _: {"fig15": Figure((1, 1))}
        )
        yield


@contextmanager
def _without_models():
    """Leave out growth functions and the mixed model, most of the time of a small analysis."""
    from slipscale.analysis.statistics.not_computed import NotComputed
    from slipscale.analysis.tasks.table import KINDS

    every = [statistic for kind in KINDS for statistic in kind.statistics]
    slow = [type(each) for each in every if each.key in ("growth", "mixed_model")]
    assert len(slow) == 2
    with pytest.MonkeyPatch.context() as patch:
        for each in slow:
            patch.setattr(each, "compute", lambda *_: NotComputed("left out of this test"))
        yield


@pytest.fixture(scope="module")
def without_figures():
    """Leave out figures, for modules whose tests are about something else."""
    with _without_figures():
        yield


@pytest.fixture(scope="module")
def without_models():
    """Leave out models, for modules whose tests are about something else."""
    with _without_models():
        yield


@pytest.fixture
def figures_and_models_left_out():
    """Leave out figures and models of one test, in a module whose other tests need them."""
    with _without_figures(), _without_models():
        yield


PLATE_IN_VOLTS = """
[identity]
name = "screen"
[wiring]
backend = "{backend}"
[quantity]
name = "voltage"
unit = "V"
convention = "peak"
[limits]
voltage_v_peak = 130.0
tolerance_v_peak = {tolerance_v_peak}
"""


@pytest.fixture
def plate_in_volts(tmp_path):
    """Write the signed file of a plate in V peak; ``plate_in_volts("mock")`` returns its path."""
    from slipscale.hardware.plate_file import sign

    def make(backend, tolerance_v_peak=2.5, band_hz=()):
        path = tmp_path / "screen.toml"
        text = PLATE_IN_VOLTS.format(backend=backend, tolerance_v_peak=tolerance_v_peak)
        for name, bound_hz in zip(("min", "max"), band_hz, strict=False):
            text += f"frequency_{name}_hz = {bound_hz}\n"
        path.write_text(text, encoding="utf-8")
        sign(path, beyond_by="A. Name", today=date(2026, 1, 1))
        return path

    return make
