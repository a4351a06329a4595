"""The wheel as installed: light, and with each extra, in environments of their own."""

import os
import shutil
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from slipscale.faults.extras import EXTRA_OF, how_to_install
from tools import setup

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
#: Those of the extra "all", and the cluster's; "bayes" is too large to install for a test.
EXTRAS = ("analysis", "plate", "session", "markers", "console", "export", "cluster")

TIDY = "participant_id,amplitude_um_pp,estimate\n" + "".join(
    f"{person},{amplitude},{10 + 20 * amplitude + person}\n"
    for person in range(1, 7)
    for amplitude in (0, 0.5, 1.2, 2.3)
)


def other_pythons():
    """Return the interpreters of the supported versions, this one's aside, that are here."""
    uv = shutil.which("uv") or shutil.which("uv", path=ROOT / ".setup/bin")
    versions = [f"3.{minor}" for minor in range(setup.OLDEST[1], setup.NEWEST[1] + 1)]
    here = f"3.{sys.version_info.minor}"
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    folders = [os.environ["PATH"], *(str(path) for path in pyenv.glob("3.*/bin"))]
    found = []
    for version in versions if uv else ():
        look = [uv, "python", "find", "--no-python-downloads", "--system", version]
        path = {**os.environ, "PATH": os.pathsep.join(folders)}
        done = subprocess.run(look, env=path, capture_output=True, text=True, check=False)
        if version != here and done.returncode == 0:
            found.append(done.stdout.strip())
    return found


class Installation:
    """A virtual environment with the wheel in it."""

    def __init__(self, folder, wheel, extra, python=sys.executable):
        self.folder = folder
        uv = shutil.which("uv") or shutil.which("uv", path=ROOT / ".setup/bin")
        venv = folder / "venv"
        what = f"slipscale[{extra}] @ {wheel.as_uri()}" if extra else str(wheel)
        if uv:
            make = [uv, "venv", "--quiet", "--python", python, venv]
            install = [uv, "pip", "install", "--quiet", "--python", setup.python_in(venv)]
        else:
            make = [python, "-m", "venv", venv]
            install = [setup.python_in(venv), "-m", "pip", "install", "--quiet"]
        subprocess.run(make, check=True)
        subprocess.run([*install, "--constraint", pins(folder), what], check=True)
        self.command = setup.python_in(venv).with_name("slipscale")

    def run(self, *words):
        """Run the command in a folder that is not the checkout; return status, output, errors."""
        done = subprocess.run(
            [self.command, *words],
            cwd=self.folder,
            env={**os.environ, "PYTHONPATH": ""},
            capture_output=True,
            text=True,
            check=False,
        )
        return done.returncode, done.stdout, done.stderr


def pins(folder):
    """Write the pinned versions without their hashes, which a wheel of our own has not."""
    lines = (ROOT / "requirements.txt").read_text(encoding="utf-8").splitlines()
    path = folder / "pins.txt"
    kept = (line.removesuffix(" \\") for line in lines if not line.startswith(" "))
    path.write_text("\n".join(kept), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def light(tmp_path_factory, wheel):
    return Installation(tmp_path_factory.mktemp("light"), wheel, "")


def test_a_light_installation_reconstructs_a_published_table_to_a_page(light):
    status, out, err = light.run("reconstruct", "biet2007_table3", "--html", "page.html")
    assert (status, err) == (0, "")
    assert "0 um" in out
    assert "<svg" in (light.folder / "page.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "words, module, extra",
    [
        (("analyse", "tidy.csv"), "pandas", "analysis"),
        (("plate", "list"), "serial", "plate"),
        (("reproduce", "fig12.frequency"), "pandas", "analysis"),
    ],
)
def test_a_light_installation_says_by_name_what_a_command_lacks(light, words, module, extra):
    (light.folder / "tidy.csv").write_text(TIDY, encoding="utf-8")
    status, out, err = light.run(*words)
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert f"'{module}'" in err
    assert f"pip install 'slipscale[{extra}]'" in err


def test_a_light_installation_still_knows_studies_and_journals(light):
    status, out, err = light.run("study", "validate", "biet2007")
    assert (status, err) == (0, "")
    assert "no fault" in out


@pytest.mark.parametrize("python", other_pythons(), ids=lambda path: Path(path).name)
def test_the_wheel_works_on_the_other_pythons_that_are_here(tmp_path, wheel, python):
    status, out, err = Installation(tmp_path, wheel, "", python).run(
        "reconstruct", "biet2007_table3"
    )
    assert (status, err) == (0, "")
    assert "0 um" in out


@pytest.mark.parametrize(
    "extra, words, told",
    [
        ("analysis", ("analyse", "tidy.csv", "--out", "results"), "results"),
        ("console", ("lab", "--help"), "--no-browser"),
        ("plate", ("plate", "list"), "mock"),
        ("session", ("run", "--help"), "--participant"),
    ],
)
def test_each_extra_brings_what_its_commands_need(tmp_path, wheel, extra, words, told):
    (tmp_path / "tidy.csv").write_text(TIDY, encoding="utf-8")
    status, out, err = Installation(tmp_path, wheel, extra).run(*words)
    assert (status, err) == (0, "")
    assert told in out


def test_every_package_of_an_extra_has_its_line_in_the_table_of_modules():
    names = {
        requirement.split(">")[0].lower().replace("_", "-")
        for extra in EXTRAS
        for requirement in PROJECT["optional-dependencies"][extra]
    }
    installed = packages_distributions()
    here = {module: extra for module, extra in EXTRA_OF.items() if extra in EXTRAS}
    covered = {
        distribution.lower().replace("_", "-")
        for module in here
        for distribution in installed[module]
    }
    assert names | {"pyvisa"} == covered  # under PyVISA-py, and imported as itself
    for module, extra in here.items():
        brought = " ".join(PROJECT["optional-dependencies"][extra]).lower().replace("_", "-")
        assert any(each.lower().replace("_", "-") in brought for each in installed[module])


def test_a_module_of_no_extra_is_a_defect_of_ours_and_not_told_as_the_users():
    assert how_to_install("nonsense") is None
    assert "slipscale[plate]" in how_to_install("serial.tools.list_ports")
