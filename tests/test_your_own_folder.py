"""A file or folder of the user's that bears the name of one of ours: what happens is said."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import slipscale

COMMAND = str(Path(sys.executable).with_name("slipscale"))
SCRIPT = "import slipscale\nfrom analysis.pipeline import analyse\nprint(analyse.__module__)\n"


def run(words, folder, **environment):
    return subprocess.run(
        words,
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture(params=["analysis/__init__.py", "analysis.py", "faults.py"])
def own(request, tmp_path):
    """A folder with a user's script beside a package or module that has the name of one of ours."""
    path = tmp_path / request.param
    path.parent.mkdir(exist_ok=True)
    path.write_text("MINE = True\n")
    (tmp_path / "script.py").write_text(SCRIPT)
    return path


def test_the_command_works_in_a_folder_that_holds_a_package_of_our_name(own):
    done = run([COMMAND, "study", "validate", "biet2007"], own.parents[own.name == "__init__.py"])
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("words", [[COMMAND], [sys.executable, "-m", "slipscale"]])
def test_the_command_says_which_file_hides_ours_and_what_to_do(own, tmp_path, words):
    done = run([*words, "study", "validate", "biet2007"], tmp_path, PYTHONPATH=str(tmp_path))
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith("slipscale: 'import ")
    assert str(own) in done.stderr
    assert "Rename" in done.stderr


def test_a_script_that_imports_slipscale_first_is_told_the_same(own, tmp_path):
    done = run([sys.executable, "script.py"], tmp_path)
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert last.startswith("ImportError: 'import ")
    assert str(own) in last
    assert str(Path(slipscale.__file__).parent) in last


def test_a_folder_without_an_init_file_hides_nothing(tmp_path):
    (tmp_path / "analysis").mkdir()
    (tmp_path / "analysis" / "notes.py").write_text("")
    (tmp_path / "script.py").write_text(SCRIPT)
    done = run([sys.executable, "script.py"], tmp_path)
    assert (done.returncode, done.stdout) == (0, "analysis.pipeline\n")


def test_every_package_of_the_wheel_is_looked_for():
    root = Path(slipscale.__file__).parent
    assert set(slipscale.PACKAGES) == {path.parent.name for path in root.glob("*/py.typed")}
