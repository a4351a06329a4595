"""The wheel as installed: light, and with each extra, in environments of their own.

No package is installed: an environment is a site folder with links to the wheel's contents and to
those packages of this environment that the extra requires. An undeclared import fails.
"""

import ast
import os
import subprocess
import sys
import tomllib
import venv
import zipfile
from importlib.metadata import distribution, packages_distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from slipscale.faults.extras import EXTRA_OF, how_to_install
from tools import setup

ROOT = Path(__file__).parents[2]
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = PYPROJECT["project"]
LEFT_OUT = set(PYPROJECT["tool"]["uv"]["exclude-dependencies"])
#: Those of the extra "all", and the cluster's; "bayes" is too large to install for a test.
EXTRAS = ("analysis", "plate", "session", "markers", "console", "export", "cluster")

TIDY = "participant_id,amplitude_um_pp,estimate\n" + "".join(
    f"{person},{amplitude},{10 + 20 * amplitude + person}\n"
    for person in range(1, 7)
    for amplitude in (0, 0.5, 1.2, 2.3)
)


def required(texts, extra=""):
    """Return the distributions that requirements lead to, as an installer would; no duplicates."""
    found, waiting = {}, [(text, extra) for text in texts]
    while waiting:
        text, extra = waiting.pop()
        requirement = Requirement(text)
        if requirement.marker and not requirement.marker.evaluate({"extra": extra}):
            continue
        key = (requirement.name.lower(), frozenset(requirement.extras))
        if key in found or key[0] in LEFT_OUT:
            continue
        found[key] = distribution(requirement.name)
        inner = found[key].requires or []
        waiting += [(each, part) for each in inner for part in ("", *requirement.extras)]
    return found.values()


class Installation:
    """A virtual environment that holds the wheel and what it requires, and nothing else."""

    def __init__(self, folder, wheel, *extras):
        self.folder = folder
        venv.create(folder / "venv", symlinks=os.name != "nt")
        self.python = setup.python_in(folder / "venv")
        ask = "import sysconfig; print(sysconfig.get_path('purelib'))"
        site = subprocess.run([self.python, "-c", ask], check=True, capture_output=True, text=True)
        self.site = Path(site.stdout.strip())
        for each in wheel.iterdir():
            (self.site / each.name).symlink_to(each)
        texts = [each for extra in extras for each in PROJECT["optional-dependencies"][extra]]
        for package in required(PROJECT["dependencies"] + texts):
            self.link(package)

    def link(self, package):
        """Link the modules, libraries and metadata of an installed distribution."""
        for name in {file.parts[0] for file in package.files} - {"..", "__pycache__"}:
            link = self.site / name
            if not link.exists():  # two distributions share a namespace
                link.symlink_to(package.locate_file(name))

    def run(self, *words):
        """Run the command in a folder that is not the checkout; return status, output, errors."""
        done = subprocess.run(
            [self.python, "-m", "slipscale", *words],
            cwd=self.folder,
            env={**os.environ, "PYTHONPATH": ""},
            capture_output=True,
            text=True,
            check=False,
        )
        return done.returncode, done.stdout, done.stderr


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Return the folder with the wheel's contents: all installations share its bytecode."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    with zipfile.ZipFile(next(folder.glob("*.whl"))) as archive:
        archive.extractall(folder / "contents")
    return folder / "contents"


@pytest.fixture(scope="module")
def light(tmp_path_factory, wheel):
    return Installation(tmp_path_factory.mktemp("light"), wheel)


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


@pytest.mark.parametrize(
    "extras, words, told",
    [
        (("analysis",), ("analyse", "tidy.csv", "--out", "results"), "results"),
        (("analysis", "export"), ("export", "--help"), "--out"),
        (("console",), ("lab", "--help"), "--no-browser"),
        (("plate",), ("plate", "list"), "mock"),
        (("session",), ("run", "--help"), "--participant"),
    ],
)
def test_each_extra_brings_what_its_commands_need(tmp_path, wheel, extras, words, told):
    (tmp_path / "tidy.csv").write_text(TIDY, encoding="utf-8")
    status, out, err = Installation(tmp_path, wheel, *extras).run(*words)
    assert (status, err) == (0, "")
    assert told in out


def test_every_module_that_the_package_imports_anywhere_is_required_by_the_base_or_an_extra():
    folders = PYPROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["sources"]
    scripts = ROOT / "analysis" / "export" / "scripts"
    paths = {path for folder in folders for path in (ROOT / folder).rglob("*.py")}
    nodes = [
        node
        for path in paths
        if scripts not in path.parents
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    ]
    names = [node.module for node in nodes if isinstance(node, ast.ImportFrom) and not node.level]
    names += [each.name for node in nodes if isinstance(node, ast.Import) for each in node.names]
    imported = {name.partition(".")[0] for name in names} - {"_typeshed", "slipscale"}
    extras = PROJECT["optional-dependencies"]
    texts = PROJECT["dependencies"] + [each for extra in EXTRAS for each in extras[extra]]
    brought = {package.name for package in required(texts)}
    found = packages_distributions()
    unmet = {
        name
        for name in imported - set(sys.stdlib_module_names)
        if not brought & set(found.get(name, ()))
    }
    assert len(imported) > 100
    assert unmet == {"jax", "numpyro", "nidaqmx"}  # of "bayes" and "daq", which no test installs


def test_every_package_of_an_extra_has_its_line_in_the_table_of_modules():
    names = {
        requirement.split(">")[0].lower().replace("_", "-")
        for extra in EXTRAS
        for requirement in PROJECT["optional-dependencies"][extra]
        if "sys_platform" not in requirement  # limits what another package brings
    }
    installed = packages_distributions()
    here = {module: extra for module, extra in EXTRA_OF.items() if extra in EXTRAS}
    covered = {
        distribution.lower().replace("_", "-")
        for module in here
        for distribution in installed[module]
    }
    assert names == covered
    for module, extra in here.items():
        brought = " ".join(PROJECT["optional-dependencies"][extra]).lower().replace("_", "-")
        assert any(each.lower().replace("_", "-") in brought for each in installed[module])


def test_a_module_of_no_extra_is_a_defect_of_ours_and_not_told_as_the_users():
    assert how_to_install("nonsense") is None
    assert "slipscale[plate]" in how_to_install("serial.tools.list_ports")


def test_on_a_python_without_psychopy_the_advice_is_another_python(monkeypatch):
    monkeypatch.setattr(sys, "version_info", (3, 13, 1))
    assert "no release for Python 3.13; install Slipscale with Python 3.11 or 3.12" in (
        how_to_install("psychopy.visual")
    )
    monkeypatch.setattr(sys, "version_info", (3, 12, 1))
    assert "'slipscale[session]'" in how_to_install("psychopy.visual")
