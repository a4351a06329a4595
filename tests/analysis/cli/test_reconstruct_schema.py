"""What `--json` writes is what its schema says, and the R example reads it."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from slipscale import commands

REFERENCE = Path(__file__).parents[3] / "docs" / "reference"
HEADER = "label,n,mean,sd,scale_maximum\n"
TABLES = {
    "paired": HEADER + "a,5,2.40,1.14,9\nb,5,6.40,1.14,9\n",
    "large": HEADER + "a,300,50.00,10.00,100\nb,300,60.00,10.00,100\n",
    "inconsistent": HEADER + "a,28,5.19,1.00,10\nb,28,5.18,1.02,10\n",
}


@pytest.fixture(scope="module")
def schema():
    return Draft202012Validator(
        json.loads((REFERENCE / "reconstruct.schema.json").read_text("utf-8"))
    )


@pytest.mark.parametrize("design", ["paired", "independent"])
@pytest.mark.parametrize("name", TABLES)
def test_every_answer_is_what_the_schema_says(schema, name, design, tmp_path, capsys):
    (tmp_path / "t.csv").write_text(TABLES[name])
    words = ["reconstruct", str(tmp_path / "t.csv"), "--json", "--conclusions", "--design", design]
    commands.main([*words, *(["--variants"] if name == "paired" else [])])
    answer = json.loads(capsys.readouterr().out)
    schema.validate(answer)
    answer["columns"][0]["multisets"] = 7
    assert any("7 is not of type" in fault.message for fault in schema.iter_errors(answer))


def test_printed_tests_are_what_the_schema_says(schema, tmp_path, capsys):
    (tmp_path / "t.toml").write_text(
        """
[[column]]
n = 5
mean = 2.40
sd = 1.14
[[column]]
n = 5
mean = 6.40
sd = 1.52
[[test]]
kind = "paired_t"
p_below = 0.05
[[test]]
kind = "rm_f"
statistic = 99.0
[[test]]
kind = "welch_t"
statistic = 4.71
"""
    )
    commands.main(["reconstruct", str(tmp_path / "t.toml"), "--json"])
    found = json.loads(capsys.readouterr().out)
    schema.validate(found)
    assert [test["verdict"] for test in found["tests"]] == ["possible", "impossible", "possible"]
    assert found["columns"][0]["scale_is_printed"] is False


@pytest.mark.skipif(shutil.which("Rscript") is None, reason="R is not installed")
def test_the_r_example_runs_and_prints_what_the_page_says(tmp_path):
    page = (REFERENCE.parent / "how-to" / "reconstruct.md").read_text("utf-8")
    (code,) = re.findall(r"^```r\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    (tmp_path / "example.R").write_text(code)
    command = Path(sys.executable).with_name("slipscale")
    environment = {"PATH": f"{command.parent}:/usr/bin:/bin", "LC_ALL": "C.UTF-8"}
    done = subprocess.run(
        ["Rscript", "--vanilla", tmp_path / "example.R"],
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,
        env=environment,
    )
    printed = re.findall(r"^#> (.*)$", code, re.MULTILINE)
    assert printed
    assert done.stdout.split("\n")[: len(printed)] == printed
