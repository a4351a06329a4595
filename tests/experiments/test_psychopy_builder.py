"""The plate in PsychoPy's Builder: found by its loader, written into a script, and run."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from slipscale.hardware.emulator.process import EmulatorProcess

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
exp = experiment.Experiment()
exp.settings.params["Show info dlg"].val = False
exp.settings.params["Full-screen window"].val = False
exp.addRoutine("trial")
felt = component(exp, "trial", name="felt", deviceLabel=sys.argv[3], stopVal=0.3)
felt.params["amplitude_um_pp"].val = sys.argv[4]
exp.routines["trial"].addComponent(felt)
exp.flow.addRoutine(exp.routines["trial"], 0)
device = backend(profile=backend.getAvailableDevices()[0])
device.name = "plate"
device.params["spec"].val = sys.argv[2]
prefs.devices["plate"] = device
code = exp.writeScript(expPath=sys.argv[1], target="PsychoPy")
open(sys.argv[1], "w", encoding="utf-8").write(code)
print(json.dumps(found), flush=True)
"""


@pytest.fixture(scope="module")
def board():
    # PsychoPy's first frames hold the interpreter for longer than the shipped watchdog waits on a
    # busy machine.
    with EmulatorProcess("--watchdog", "2000") as board:
        yield board


@pytest.fixture
def build(tmp_path, display):
    """Return a function that builds an experiment and runs it: (what was found, the run)."""
    # PsychoPy keeps its list of devices in the user's folder: a new one for each test.
    env = {**os.environ, "HOME": str(tmp_path), "DISPLAY": display or ""}

    def python(*words):
        return subprocess.run(
            [sys.executable, *words],
            cwd=tmp_path,
            env=env,
            capture_output=True,
            text=True,
            check=False,
        )

    def run(spec, device="plate", amplitude="1.2"):
        script = tmp_path / "experiment.py"
        built = python("-c", BUILD, script, spec, device, amplitude)
        assert built.returncode == 0, built.stderr
        (line,) = (line for line in built.stdout.splitlines() if line.startswith("{"))
        return json.loads(line), python(script, "--pilot")

    return run


def test_an_experiment_of_builder_moves_the_plate_records_it_and_leaves_it_silent(
    board, build, tmp_path
):
    found, done = build(f"serial:{board.port}")
    assert found["in the dialog"]
    assert found["label"] == "Slipscale plate"
    assert "mock" in found["devices"]
    assert done.returncode == 0, done.stderr
    (table,) = (tmp_path / "data").glob("*.csv")
    with table.open(encoding="utf-8-sig") as stream:
        (row,) = csv.DictReader(stream)
    assert float(row["felt.amplitude_um_pp"]) == 1.2
    assert float(row["felt.readback_um_pp"]) == pytest.approx(1.2, abs=0.03)
    assert not board.state()["vibrates"]
    # Builder looks for the icon in a folder for each of its themes.
    icon, plain = map(Path, found["icons"])
    for theme in ("light", "dark", "classic"):
        for name in ("plate.png", "plate@2x.png"):
            assert (plain.parent / theme / name).exists()
    assert icon.exists()


def test_an_amplitude_beyond_the_plate_ends_the_script_with_the_plate_silent(board, build):
    _, done = build(f"serial:{board.port}", amplitude="9")
    assert done.returncode != 0
    assert "OverLimit" in done.stderr
    assert not board.state()["vibrates"]


def test_a_component_whose_device_was_never_added_says_what_to_do(build):
    _, done = build("mock", device="other")
    assert done.returncode != 0
    assert "add a Slipscale plate of that name in Builder's device manager" in done.stderr
