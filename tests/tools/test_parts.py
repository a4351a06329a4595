"""One worker runs the tests folder after folder, and one line counts them all."""

from pathlib import Path

from tests.support.own_modules import ROOT
from tests.support.parts import main, parts

PASSES_AND_SKIPS = """
import pytest

def test_it():
    assert True

def test_other():
    pytest.skip("no reason")
"""
FAILS = "def test_it():\n    assert False\n"
DIES = "import os, signal\ndef test_it():\n    os.kill(os.getpid(), signal.SIGKILL)\n"


def test_one_line_counts_all_parts(tmp_path, monkeypatch, capfd):
    for folder in ("src/slipscale", "tools/site", "tests/data"):
        (tmp_path / folder).mkdir(parents=True)
    for name, text in {"a": FAILS, "b": DIES, "c": PASSES_AND_SKIPS}.items():
        (tmp_path / "tests" / name).mkdir()
        (tmp_path / "tests" / name / f"test_{name}.py").write_text(text)
    (tmp_path / "tests" / "test_in_no_folder.py").write_text(PASSES_AND_SKIPS)
    monkeypatch.chdir(tmp_path)
    assert main(["-n", "1"]) == 1
    assert "All parts: 1 failed, 1 error, 2 passed, 2 skipped in" in capfd.readouterr().out
    assert main(["-n", "1", "tests/c"]) == 0
    assert "All parts" not in capfd.readouterr().out


def test_every_test_file_of_this_project_is_in_a_part():
    given = {Path(place) for part in parts(ROOT) for place in part}
    for path in (ROOT / "tests").rglob("test_*.py"):
        assert given & {path.relative_to(ROOT), *path.relative_to(ROOT).parents}, path
