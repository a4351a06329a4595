"""The plate inside a PsychoPy script, which is a process of its own as it is for its users."""

import csv
import json
import os
import subprocess
import sys

import pytest

from tests.support.reported_plate import ReportedPlate

SCRIPT = """
import json, sys
from psychopy import plugins
plugins.activatePlugins()
import psychopy.hardware
from psychopy.hardware import DeviceManager

plate = DeviceManager.addDevice(
    "slipscale.experiments.psychopy_plate.SlipscalePlate", "plate", spec=sys.argv[1]
)
made = plate.present(1.2)
plate.check()
print(json.dumps({
    "class": psychopy.hardware.SlipscalePlate.__name__,
    "same": DeviceManager.getDevice("plate") == plate,
    "readback": made.readback.level,
    "available": [each["spec"] for each in plate.getAvailableDevices()],
}), flush=True)
from slipscale.experiments.psychopy_builder.plate_output import PlateOutput
spec = f"mock:plate={sys.argv[3]}"
DeviceManager.addDevice(
    "slipscale.experiments.psychopy_plate.SlipscalePlate", "screen", spec=spec
)
output = PlateOutput(device="screen")
output.amplitude_um_pp = 40.0
output.start()
print(json.dumps(output.columns), flush=True)
try:
    output.amplitude_um_pp = None
except ValueError as error:
    print(json.dumps(str(error)), flush=True)
if sys.argv[2] == "error":
    raise RuntimeError("a script's own mistake")
try:
    plate.present(9.0)
except Exception as error:
    print(json.dumps(type(error).__name__), flush=True)
"""


@pytest.fixture
def reported(tmp_path_factory):
    return ReportedPlate(tmp_path_factory.mktemp("reported"))


def run_script(reported, tmp_path, way, plate):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT, encoding="utf-8")
    return subprocess.run(
        [sys.executable, script, reported.spec, way, plate],
        env=os.environ | reported.environment,
        capture_output=True,
        text=True,
        check=False,
    )


def told(done):
    """Return the script's own lines of JSON among what PsychoPy says."""
    return [json.loads(line) for line in done.stdout.splitlines() if line[:1] in '{"']


def test_a_psychopy_script_presents_a_surface_and_leaves_the_plate_silent(
    reported, tmp_path, plate_in_volts
):
    done = run_script(reported, tmp_path, "end", plate_in_volts("mock", tolerance_v_peak=2.0))
    assert done.returncode == 0, done.stderr
    found, screen, empty, refusal = told(done)
    assert found["class"] == "SlipscalePlate"
    assert found["same"] is True
    assert found["readback"] == pytest.approx(1.2, abs=0.03)
    assert "mock" in found["available"]
    assert screen["voltage_v_peak"] == 40.0
    assert screen["readback_v_peak"] == pytest.approx(40.0, abs=1.5)
    assert empty.startswith("the amplitude of a Slipscale plate is None; expected a number")
    assert refusal == "OverLimit"
    assert not reported.vibrates()


def test_a_script_that_fails_leaves_the_plate_silent(reported, tmp_path, plate_in_volts):
    done = run_script(reported, tmp_path, "error", plate_in_volts("mock", tolerance_v_peak=2.0))
    assert done.returncode == 1
    assert told(done)[0]["readback"] == pytest.approx(1.2, abs=0.03)
    assert not reported.vibrates()


BUILDER = """
import sys
from psychopy import plugins
plugins.activatePlugins()
from psychopy.experiment import Experiment
from psychopy.experiment.components.code import CodeComponent
from psychopy.experiment.loops import TrialHandler
from psychopy.experiment.routines import Routine
from slipscale.experiments.psychopy_builder.component import SlipscalePlateComponent

made = Experiment()
for key in ("Full-screen window", "Show info dlg"):
    made.settings.params[key].val = False
for number, (updates, amplitude) in enumerate(VALUES):
    routine = Routine(f"feel_{number}", exp=made)
    made.addRoutine(routine.name, routine)
    plate = SlipscalePlateComponent(
        made, routine.name, name=f"plate_{number}", stopType="duration (frames)", stopVal=5,
        deviceLabel="plate", amplitude_um_pp=amplitude,
    )
    plate.params["amplitude_um_pp"].updates = updates
    routine.addComponent(plate)
    if number == 0:
        device = "slipscale.experiments.psychopy_plate.SlipscalePlate"
        add = "from psychopy.hardware import DeviceManager as D\\n"
        add += f"D.addDevice({device!r}, 'plate', spec='mock')"
        routine.insert(0, CodeComponent(made, routine.name, name="code"))
        routine[0].params["Before Experiment"].val = add
    made.flow.addRoutine(routine, number)
conditions = [{"amp": 0.5}, {"amp": 1.1}]
loop = TrialHandler(
    exp=made, name="trials", loopType="sequential", nReps=1, conditions=conditions,
    conditionsFile="conditions.csv",
)
made.flow.addLoop(loop, 0, len(VALUES))
script = made.writeScript(target="PsychoPy")
with open(sys.argv[1], "w", encoding="utf-8") as file:
    file.write(script if isinstance(script, str) else script.getvalue())
"""
# How Builder's dialog stores a value, and the level that it means for a row of the conditions.
VALUES = {
    ("constant", "1.2"): lambda _: 1.2,
    ("constant", "$amp"): lambda amp: amp,
    ("set every repeat", "1.2"): lambda _: 1.2,
    ("set every repeat", "$amp"): lambda amp: amp,
    ("set every repeat", "amp"): lambda amp: amp,
    ("set every repeat", "$2 * amp"): lambda amp: 2 * amp,
}


def test_an_amplitude_of_a_builder_loop_is_that_of_each_repeat(display, tmp_path):
    """A routine with a duration in seconds ends before its first frame on a busy machine."""
    make, script = tmp_path / "make.py", tmp_path / "loop.py"
    make.write_text(f"VALUES = {list(VALUES)}\n{BUILDER}", encoding="utf-8")
    (tmp_path / "conditions.csv").write_text("amp\n0.5\n1.1\n", encoding="utf-8")
    environment = os.environ | ({"DISPLAY": display} if display else {})
    for arguments in ([make, script], [script]):
        subprocess.run(
            [sys.executable, *arguments],
            cwd=tmp_path,
            env=environment,
            check=True,
            capture_output=True,
        )
    (table,) = (tmp_path / "data").glob("*.csv")
    with table.open(encoding="utf-8-sig") as file:
        rows = [row for row in csv.DictReader(file) if row["amp"]]
    assert [float(row["amp"]) for row in rows] == [0.5, 1.1]
    for row in rows:
        for number, meant in enumerate(VALUES.values()):
            level = meant(float(row["amp"]))
            assert float(row[f"plate_{number}.amplitude_um_pp"]) == pytest.approx(level)
            assert float(row[f"plate_{number}.readback_um_pp"]) == pytest.approx(level, abs=0.05)
