"""The plate inside a PsychoPy script, which is a process of its own as it is for its users."""

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
    found, screen, refusal = told(done)
    assert found["class"] == "SlipscalePlate"
    assert found["same"] is True
    assert found["readback"] == pytest.approx(1.2, abs=0.03)
    assert "mock" in found["available"]
    assert screen["voltage_v_peak"] == 40.0
    assert screen["readback_v_peak"] == pytest.approx(40.0, abs=1.5)
    assert refusal == "OverLimit"
    assert not reported.vibrates()


def test_a_script_that_fails_leaves_the_plate_silent(reported, tmp_path, plate_in_volts):
    done = run_script(reported, tmp_path, "error", plate_in_volts("mock", tolerance_v_peak=2.0))
    assert done.returncode == 1
    assert told(done)[0]["readback"] == pytest.approx(1.2, abs=0.03)
    assert not reported.vibrates()
