"""docs/extending/adding-a-protocol.md: its example is built, installed and used."""

import json

import pytest

from tests.support.example_package import COMMANDS, ExamplePackage, tables

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


pytestmark = pytest.mark.window  # `slipscale check` looks at the display


def test_the_page_is_followed_from_validate_to_analyse(tmp_path, display):
    package = ExamplePackage("roughness", tmp_path)
    said = package.run(
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
    package.run(UNDISTURBED)
    whole = tables(tmp_path / "whole")
    coarse = whole["sub-01_task-coarse_run-01_beh.tsv"].decode().splitlines()
    assert len(coarse) == 1 + 6
    assert "interval2_readback_um_pp" in coarse[0]
    assert coarse[1:] != whole["sub-01_task-fine_run-01_beh.tsv"].decode().splitlines()[1:]
    notes = json.loads(whole["sub-01_task-fine_run-01_beh.json"])["Slipscale"]
    assert notes["protocol"] == "shrinking_difference"

    # Killed in the middle of a run, gone on with, built, analysed.
    options = ("--population", "distracted", "--participants", "1", "--out", "killed")
    journal = tmp_path / "killed/sourcedata/sub-01/sub-01_run-01_journal.jsonl"
    package.kill_pilot(journal, "roughness.toml", *options)
    said = package.run(COMMANDS, f"resume {journal}", "data build killed", "analyse killed")
    assert tables(tmp_path / "killed") == whole
    assert "Shrinking differences: The mean of the last 4 differences in coarse was" in said
    out = tmp_path / "killed/derivatives/slipscale"
    own = json.loads((out / "inference.json").read_text())["own_last_differences"]
    assert set(own["numbers"]) == {"coarse", "fine"}
    assert (
        json.loads((out / "results.json").read_text())["software"]["slipscale-roughness"] == "1.0"
    )
    assert (out / "own_last_differences.svg").exists()
    assert len((out / "own_last_differences.csv").read_text().splitlines()) == 1 + 2
    assert "in the package slipscale-roughness 1.0" in (out / "report.html").read_text()
