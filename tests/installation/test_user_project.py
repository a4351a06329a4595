"""A laboratory's own project may hold folders and modules with the names of ours."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

COMMAND = str(Path(sys.executable).with_name("slipscale"))
SCRIPT = """\
from analysis import mine
from experiments.plan import PLAN
import hardware
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.experiments.study.file import read_study
from slipscale.hardware.registry import open_plate
print(mine.NAME, PLAN, hardware.RIG, NotComputed.__module__, read_study("biet2007")[0].name)
"""
PRINTED = "my analysis my plan my rig slipscale.analysis.statistics.not_computed biet2007\n"
TEST = f"""\
def test_mine(capsys):
    import script
    assert capsys.readouterr().out == {PRINTED!r}
"""


@pytest.fixture(params=["packages", "namespace folders"])
def project(request, tmp_path):
    """A project with its own `analysis/`, `experiments/` and `hardware.py`."""
    for name, text in [
        ("analysis/mine.py", 'NAME = "my analysis"\n'),
        ("experiments/plan.py", 'PLAN = "my plan"\n'),
        ("hardware.py", 'RIG = "my rig"\n'),
        ("script.py", SCRIPT),
        ("tests/test_mine.py", TEST),
    ]:
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    if request.param == "packages":
        (tmp_path / "analysis" / "__init__.py").touch()
        (tmp_path / "experiments" / "__init__.py").touch()
    return tmp_path


def run(words, folder, **environment):
    done = subprocess.run(
        words,
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_script_imports_both(project):
    assert run([sys.executable, "script.py"], project) == PRINTED


def test_a_notebooks_kernel_imports_both(project):
    # A kernel puts the notebook's folder first in sys.path, as `python -c` does.
    assert run([sys.executable, "-c", SCRIPT], project) == PRINTED


@pytest.mark.parametrize("mode", ["prepend", "importlib"])
def test_the_projects_own_tests_import_both(project, mode):
    words = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        f"--import-mode={mode}",
        "-p",
        "no:cacheprovider",
    ]
    run([*words, "tests"], project, PYTHONPATH=str(project), PYTEST_DISABLE_PLUGIN_AUTOLOAD="1")


@pytest.mark.parametrize("words", [[COMMAND], [sys.executable, "-m", "slipscale"]])
def test_the_command_runs_in_the_project_and_with_it_on_the_path(project, words):
    said = run([*words, "study", "validate", "biet2007"], project, PYTHONPATH=str(project))
    assert "no fault" in said
