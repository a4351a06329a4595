"""What is installed is what is in the checkout: the wheel, built and run."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import slipscale

ROOT = Path(__file__).parent.parent
DATA = (".toml", ".csv", ".json", ".html", ".css", ".typed")


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder / "site"


def test_every_module_and_every_data_file_is_in_the_wheel(installed):
    wanted = {
        path.relative_to(ROOT)
        for room in slipscale.PACKAGES
        for path in (ROOT / room).rglob("*")
        if path.suffix in (".py", *DATA) and "__pycache__" not in path.parts
    } | {Path("slipscale.py")}
    assert {path for path in wanted if not (installed / path).exists()} == set()


def test_the_installed_package_runs_without_the_checkout(installed, tmp_path):
    code = (
        f"import sys; sys.path.insert(0, {str(installed)!r}); import slipscale, experiments; "
        f"assert experiments.__file__.startswith({str(installed)!r}); "
        "sys.exit(slipscale.main(['study', 'validate', 'biet2007']))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "no fault" in done.stdout
