"""The demonstration for PsychoPy's Builder is compiled, run in a window, and answered by keys."""

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

DEMO = Path(__file__).parents[2] / "docs/extending/builder"
COMPILE = """
from psychopy import plugins
plugins.activatePlugins()
from psychopy.experiment import Experiment
made = Experiment()
made.loadFromXML("slipperiness.psyexp")
script = made.writeScript(expPath="slipperiness.psyexp", target="PsychoPy")
with open("slipperiness.py", "w", encoding="utf-8") as file:
    file.write(script if isinstance(script, str) else script.getvalue())
"""


@pytest.mark.window
@pytest.mark.skipif(
    not sys.platform.startswith("linux") or not shutil.which("xdotool"),
    reason="key presses come from xdotool, under X11",
)
def test_the_demonstration_presents_and_stores_each_amplitude_twice(display, tmp_path):
    folder = shutil.copytree(DEMO, tmp_path / "demo")
    environment = os.environ | {"DISPLAY": display}
    started = {"cwd": folder, "env": environment, "text": True}
    compiled = subprocess.run(
        [sys.executable, "-c", COMPILE], check=False, capture_output=True, **started
    )
    assert compiled.returncode == 0, compiled.stderr
    log = (folder / "errors.txt").open("w+")
    session = subprocess.Popen(
        [sys.executable, "slipperiness.py"], stdout=subprocess.DEVNULL, stderr=log, **started
    )
    # Keys that are pressed while nothing asks are lost: they are pressed until the session ends.
    while session.poll() is None:
        keys = ["xdotool", "key", "--delay", "50", "5", "0", "Return"]
        subprocess.run(keys, env=environment, check=False, capture_output=True)
    log.seek(0)
    assert session.returncode == 0, log.read()
    log.close()
    (table,) = (folder / "data").glob("*.csv")
    with table.open(encoding="utf-8-sig") as file:
        rows = [row for row in csv.DictReader(file) if row["amplitude_um_pp"]]
    levels = sorted(float(row["amplitude_um_pp"]) for row in rows)
    assert levels == [0, 0, 0.5, 0.5, 1.2, 1.2, 2.3, 2.3]
    for row in rows:
        presented, readback = row["plate.amplitude_um_pp"], row["plate.readback_um_pp"]
        assert float(presented) == float(row["amplitude_um_pp"])
        assert float(readback) == pytest.approx(float(presented), abs=0.05)
        # Keys are pressed at random moments of the screen.
        answer = row["estimate.text"].split()
        assert answer
        assert all(each.isdigit() for each in answer)
