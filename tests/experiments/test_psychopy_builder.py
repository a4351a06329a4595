"""The plate in PsychoPy's Builder: found by its loader, written into a script, and run."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.reported_plate import ReportedPlate

# What a person does in Builder's window: add a plate to the device manager, put the component
# into a routine, save the script.
BUILD = """
import json, sys
from psychopy import plugins
plugins.activatePlugins()
from psychopy import experiment, prefs
from psychopy.experiment.devices import DeviceBackend, getAllDeviceBackends

component = experiment.getAllComponents()["SlipscalePlateComponent"]
backend = getAllDeviceBackends()["SlipscalePlateBackend"]
found = {
    "in the dialog": backend in DeviceBackend.getAllBackends(),
    "label": backend.getTemplateJSON()["label"],
    "devices": [each["spec"] for each in backend.getAvailableDevices()],
    "icons": [str(backend.getIconFile()), str(component.iconFile)],
}
for path, spec, label, amplitude in json.loads(sys.argv[1]):
    exp = experiment.Experiment()
    exp.settings.params["Show info dlg"].val = False
    exp.settings.params["Full-screen window"].val = False
    exp.addRoutine("trial")
    felt = component(
        exp, "trial", name="felt", deviceLabel=label, stopType="duration (frames)", stopVal=60
    )
    felt.params["amplitude_um_pp"].val = amplitude
    exp.routines["trial"].addComponent(felt)
    exp.flow.addRoutine(exp.routines["trial"], 0)
    device = backend(profile=backend.getAvailableDevices()[0])
    device.name = "plate"
    device.params["spec"].val = spec
    prefs.devices["plate"] = device
    code = exp.writeScript(expPath=path, target="PsychoPy")
    open(path, "w", encoding="utf-8").write(code)
print(json.dumps(found), flush=True)
"""


@pytest.fixture(scope="module")
def reported(tmp_path_factory):
    return ReportedPlate(tmp_path_factory.mktemp("reported"))


@pytest.fixture(scope="module")
def python(tmp_path_factory, display, reported):
    """Return a function that runs Python in a folder that is also the user's.

    PsychoPy keeps its list of devices in the user's folder.
    """
    home = tmp_path_factory.mktemp("builder")
    env = {**os.environ, **reported.environment, "HOME": str(home), "DISPLAY": display or ""}

    def run(*words):
        command = [sys.executable, *words]
        return subprocess.run(
            command, cwd=home, env=env, capture_output=True, text=True, check=False
        )

    run.folder = home
    return run


@pytest.fixture(scope="module")
def built(python, reported):
    """Build three experiments in one process, since Builder takes seconds; return what it found.

    The duration is counted in frames: a routine of some seconds ends before its first frame if the
    machine is slow enough.
    """
    scripts = [
        ("plays.py", reported.spec, "plate", "1.2"),
        ("beyond.py", reported.spec, "plate", "9"),
        ("unknown.py", "mock", "other", "1.2"),
    ]
    done = python("-c", BUILD, json.dumps(scripts))
    assert done.returncode == 0, done.stderr
    (line,) = (line for line in done.stdout.splitlines() if line.startswith("{"))
    return json.loads(line)


def test_an_experiment_of_builder_moves_the_plate_records_it_and_leaves_it_silent(
    reported, built, python
):
    assert built["in the dialog"]
    assert built["label"] == "Slipscale plate"
    assert "mock" in built["devices"]
    data = python.folder / "data"
    others = set(data.glob("*.csv"))  # of a script that ran before
    done = python("plays.py", "--pilot")
    assert done.returncode == 0, done.stderr
    (table,) = set(data.glob("*.csv")) - others
    with table.open(encoding="utf-8-sig") as stream:
        (row,) = csv.DictReader(stream)
    assert float(row["felt.amplitude_um_pp"]) == 1.2
    assert float(row["felt.readback_um_pp"]) == pytest.approx(1.2, abs=0.03)
    assert not reported.vibrates()
    # Builder looks for the icon in a folder for each of its themes.
    icon, plain = map(Path, built["icons"])
    for theme in ("light", "dark", "classic"):
        for name in ("plate.png", "plate@2x.png"):
            assert (plain.parent / theme / name).exists()
    assert icon.exists()


def test_scripts_that_fail_say_why_and_leave_the_plate_silent(reported, built, python):
    """A device that was never added, and an amplitude beyond the plate; PsychoPy takes seconds."""
    one_then_other = (
        "import runpy, traceback\n"
        "try: runpy.run_path('unknown.py', run_name='__main__')\n"
        "except Exception: traceback.print_exc()\n"
        "runpy.run_path('beyond.py', run_name='__main__')"
    )
    done = python("-c", one_then_other, "--pilot")
    assert done.returncode != 0
    assert "add a Slipscale plate with that name in Builder's device manager" in done.stderr
    assert "OverLimit" in done.stderr.rpartition("Traceback")[2]
    assert not reported.vibrates()
