"""docs/extending/adding-a-protocol.md: its example is built, installed and used."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[3] / "docs" / "extending" / "roughness"
# Commands, one after another in one process: most of a short one's time is its imports.
COMMANDS = """
import shlex, sys
from slipscale.commands import main
sys.exit(max([main(shlex.split(line)) for line in sys.argv[1:]]))
"""
# A pilot without its analysis, which takes as long as all else.
UNDISTURBED = """
from pathlib import Path
from slipscale.experiments.participants.simulated_people.population import read_population
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
people = read_population("distracted")
plans = pilot_plans(
    "roughness.toml", participants=1, seed=None, language=None, population=people
)
run_pilot(Path("whole"), plans, tell=print)
"""
SLIPSCALE = Path(sys.executable).with_name("slipscale")


pytestmark = pytest.mark.window  # `slipscale check` looks at the display


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """The example built into a wheel, and the wheel installed in its own folder."""
    folder = tmp_path_factory.mktemp("laboratory")
    for file in EXAMPLE.glob("*.*"):
        shutil.copy(file, folder)
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", "dist"]
    subprocess.run(build, cwd=folder, check=True, capture_output=True)
    (wheel,) = (folder / "dist").glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    # What is imported is what was installed, not the file that lies beside it.
    for module in folder.glob("*.py"):
        module.unlink()
    return folder


@pytest.fixture
def slipscale(package, display):
    """Return a function that runs a command with the package installed."""
    environment = {**os.environ, "PYTHONPATH": str(package / "site"), "COLUMNS": "200"}

    def run(*words, wait=True):
        if not wait:
            return subprocess.Popen(
                [SLIPSCALE, *words], cwd=package, env=environment, stdout=subprocess.DEVNULL
            )
        command = [sys.executable, "-c", *words]
        done = subprocess.run(
            command, cwd=package, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


def tables(folder):
    return {
        path.name: path.read_bytes()
        for path in sorted(folder.glob("sub-*/beh/*"))
        if path.suffix in (".tsv", ".json")
    }


def test_the_page_is_followed_from_validate_to_analyse(package, slipscale):
    said = slipscale(
        COMMANDS,
        "study validate roughness.toml",
        "study show roughness.toml",
        "check roughness.toml --out data --json --windowed",
    )
    assert "no faults (tasks: 3," in said
    assert "Shrinking difference of roughness (coarse)" in said
    findings = json.loads(said[said.rindex("\n[") :])
    assert {"name": "plate", "passed": True}.items() <= next(
        finding.items() for finding in findings if finding["name"] == "plate"
    )
    slipscale(UNDISTURBED)
    whole = tables(package / "whole")
    coarse = whole["sub-01_task-coarse_run-01_beh.tsv"].decode().splitlines()
    assert len(coarse) == 1 + 6
    assert "interval2_readback_um_pp" in coarse[0]
    assert coarse[1:] != whole["sub-01_task-fine_run-01_beh.tsv"].decode().splitlines()[1:]
    notes = json.loads(whole["sub-01_task-fine_run-01_beh.json"])["Slipscale"]
    assert notes["protocol"] == "shrinking_difference"

    # Killed in the middle of a run, gone on with, built, analysed.
    options = ("--population", "distracted", "--participants", "1", "--out", "killed")
    pilot = slipscale("pilot", "roughness.toml", *options, wait=False)
    journal = package / "killed/sourcedata/sub-01/sub-01_run-01_journal.jsonl"
    deadline = time.monotonic() + 60
    while not (journal.exists() and journal.stat().st_size > 30_000):
        assert time.monotonic() < deadline
        assert pilot.poll() is None, "it ended before it was killed"
        time.sleep(0.001)
    pilot.send_signal(signal.SIGKILL)
    pilot.wait()
    assert '"kind":"end"' not in journal.read_text()
    said = slipscale(COMMANDS, f"resume {journal}", "data build killed", "analyse killed")
    assert tables(package / "killed") == whole
    assert "Shrinking differences: The mean of the last 4 differences in coarse was" in said
    out = package / "killed/derivatives/slipscale"
    own = json.loads((out / "inference.json").read_text())["own_last_differences"]
    assert set(own["numbers"]) == {"coarse", "fine"}
    assert (
        json.loads((out / "results.json").read_text())["software"]["slipscale-roughness"] == "1.0"
    )
    assert (out / "own_last_differences.svg").exists()
    assert len((out / "own_last_differences.csv").read_text().splitlines()) == 1 + 2
    assert "in the package slipscale-roughness 1.0" in (out / "report.html").read_text()
