"""What `--json` writes is what its schema says."""

from __future__ import annotations

import json
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
