"""The example in docs/ runs and prints the paper's table."""

import runpy
import sys
from pathlib import Path

EXAMPLE = Path(__file__).parents[2] / "docs" / "examples" / "analyse_in_python.py"


def test_the_example_runs_and_says_what_the_paper_says(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", [str(EXAMPLE), str(tmp_path)])
    runpy.run_path(str(EXAMPLE))
    said = capsys.readouterr().out
    for number in ("12.75", "19.58", "56.25", "81.33", "27.25", "10.76"):
        assert number in said
    assert (tmp_path / "fig15.svg").read_text().startswith("<?xml")
