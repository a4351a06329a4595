"""A clone imports, type-checks and collects its tests without installation."""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("analysis", "experiments", "faults", "figure_style", "hardware", "stimuli")


def run(*words, cwd, **environment):
    done = subprocess.run(
        words,
        cwd=cwd,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def cloned(folder, *options):
    if not (ROOT / ".git").exists():
        pytest.skip("not a git checkout")
    run("git", "clone", "--quiet", *options, str(ROOT), str(folder), cwd=ROOT)
    return folder


@pytest.fixture(scope="module")
def clone(tmp_path_factory):
    folder = cloned(tmp_path_factory.mktemp("fresh") / "slipscale")
    run("git", "clean", "-fdxq", cwd=folder)
    return folder


def python(clone, *words):
    """Run Python with the installed dependencies, but without the installed Slipscale."""
    path = os.pathsep.join([str(clone / "src"), sysconfig.get_paths()["purelib"]])
    return run(sys.executable, "-S", *words, cwd=clone, PYTHONPATH=path)


def test_a_clone_imports_each_folder_of_its_own(clone):
    names = ", ".join(f"slipscale.{name}" for name in FOLDERS)
    found = python(clone, "-c", f"import {names}, slipscale as s; print(*s.__path__)")
    assert Path(found.strip()) == clone / "src" / "slipscale"


def test_a_clone_collects_its_tests(clone):
    told = python(clone, "-m", "pytest", "--collect-only", "-q", "tests/stimuli", "tests/faults")
    assert "tests collected" in told


def test_mypy_finds_the_modules_of_a_clone(clone):
    told = python(
        clone, "-m", "mypy", "--cache-dir", os.devnull, "src/slipscale/faults/suggestions.py"
    )
    assert told.startswith("Success")


def test_links_that_git_cannot_check_out_are_replaced_by_the_installation(tmp_path):
    """As on Windows, where a link arrives as a text file that names the folder."""
    clone = cloned(tmp_path / "slipscale", "-c", "core.symlinks=false")
    assert all((clone / "src" / "slipscale" / name).is_file() for name in FOLDERS)
    build = f"from hatchling.build import build_editable; build_editable({str(tmp_path)!r})"
    run(sys.executable, "-c", build, cwd=clone)
    assert all((clone / "src" / "slipscale" / name / "__init__.py").exists() for name in FOLDERS)
