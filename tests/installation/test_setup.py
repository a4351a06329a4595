"""The sets of pinned packages, and the program that installs them."""

import re
import sys
import tomllib
from types import SimpleNamespace

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

from tools import setup

PYPROJECT = tomllib.loads((setup.ROOT / "pyproject.toml").read_text(encoding="utf-8"))
LEFT_OUT = set(PYPROJECT["tool"]["uv"]["exclude-dependencies"])
TOOLS = {
    re.split("[<>=;]", each)[0]
    for group in PYPROJECT["dependency-groups"].values()
    for each in group
    if isinstance(each, str)  # no group in a group
    if not each.startswith(("distributed", "questplus"))  # also the analysis' and PsychoPy's
}


def text_of(name):
    return (setup.ROOT / setup.pins(name)).read_text(encoding="utf-8")


def pinned(name):
    """Return a set's pins, each a name, a version and the platforms that it is for."""
    return set(re.findall(r"^(\S+)==(\S+)(?: ; (.*?))? \\$", text_of(name), re.MULTILINE))


@pytest.mark.parametrize("name", setup.SETS)
def test_pins_have_hashes_and_name_no_index_path_or_kernel(name):
    lines = text_of(name).splitlines()
    hashed = re.compile(r"    --hash=sha256:[0-9a-f]{64}( \\)?")
    assert len(pinned(name)) == sum(not line.startswith(" ") for line in lines) > 40
    assert all(hashed.fullmatch(line) for line in lines if line.startswith(" "))
    # pip 24.1 to 25.3 fails on a marker that compares platform_release on ordinary Linux kernels.
    for unwanted in ("platform_release", "://", "index", "file:", "-e "):
        assert unwanted not in text_of(name)


def test_each_set_contains_the_one_before():
    pilot, session, test = ({pin[:2] for pin in pinned(name)} for name in setup.SETS)
    assert pilot < session < test


def test_only_the_test_set_holds_development_tools_and_none_what_psychopy_does_not_need():
    pilot, session, test = ({pin[0] for pin in pinned(name)} for name in setup.SETS)
    assert test >= TOOLS
    assert not session & TOOLS
    assert "psychopy" in session - pilot
    assert not test & LEFT_OUT


@pytest.mark.parametrize("name", setup.SETS)
def test_the_pins_hold_what_their_extras_declare(name):
    extras = PYPROJECT["project"]["optional-dependencies"]
    chosen = ["analysis"] if name == "pilot" else re.findall(r"\w+", extras["all"][0])[1:]
    declared = PYPROJECT["project"]["dependencies"] + [
        requirement for extra in chosen for requirement in extras[extra]
    ]
    assert {re.split("[<>=;]", each)[0] for each in declared} <= {pin[0] for pin in pinned(name)}


def test_each_lower_bound_is_the_version_with_which_make_lowest_tests():
    """Bounds that nothing tests are wrong sooner or later; new ones: make lowest-requirements."""
    text = (setup.ROOT / "requirements/lowest.txt").read_text(encoding="utf-8")
    lowest = {
        name.lower(): Version(version) for name, version in re.findall(r"(?m)^(\S+)==(\S+)", text)
    }
    project = PYPROJECT["project"]
    extras = {*re.findall(r"\w+", project["optional-dependencies"]["all"][0])[1:], "cluster"}
    declared = [
        Requirement(each)
        for each in project["dependencies"]
        + [each for extra in extras for each in project["optional-dependencies"][extra]]
        if "sys_platform" not in each  # tested where it applies
    ]
    bounds = {
        each.name: Version(part.version)
        for each in declared
        for part in each.specifier
        if part.operator == ">="
    }
    assert len(bounds) > 25
    assert {
        name: str(lowest[name]) for name, bound in bounds.items() if lowest[name] != bound
    } == {}


@pytest.fixture
def machine(tmp_path, monkeypatch):
    """A checkout without an environment; its installer's commands are recorded, not run."""
    commands = []

    def run(command, **_options):
        commands.append(command)
        if "-e" in command:
            setup.LINK.mkdir(exist_ok=True)
            setup.VENV.mkdir(exist_ok=True)
        return SimpleNamespace(returncode=0)

    monkeypatch.setattr(setup, "VENV", tmp_path / ".venv")
    monkeypatch.setattr(setup, "LINK", tmp_path / "analysis")
    monkeypatch.setattr(setup.subprocess, "run", run)
    monkeypatch.setattr(setup.shutil, "which", lambda _name: "uv")
    monkeypatch.setattr(sys, "version_info", (3, 12, 1, "final", 0))
    return commands


def test_an_environment_is_built_from_the_pins_alone_and_once(machine):
    assert setup.main("pilot") == 0
    assert [command[1] for command in machine] == ["venv", "pip", "pip"]
    assert machine[1][-3:] == ["--no-deps", "-r", "requirements/pilot.txt"]
    assert machine[2][-3:] == ["--no-deps", "-e", "."]
    assert setup.main("pilot") == 0
    assert len(machine) == 3


def test_a_smaller_set_is_part_of_a_larger_one_but_not_the_reverse(machine):
    setup.main("session")
    setup.main("pilot")
    assert len(machine) == 3
    setup.main("test")
    assert len(machine) == 6


def test_pins_that_changed_are_installed_again(machine):
    setup.main("pilot")
    setup.stamp("pilot").write_text("of other pins")
    setup.main("pilot")
    assert len(machine) == 6


def test_pip_takes_the_place_of_a_uv_that_fails(machine, monkeypatch):
    run = setup.subprocess.run
    failed = SimpleNamespace(returncode=1)
    monkeypatch.setattr(
        setup.subprocess, "run", lambda c, **k: failed if c[0] == "uv" else run(c, **k)
    )
    assert setup.main("session") == 0
    assert [command[1:3] for command in machine] == [["-m", "venv"], ["-m", "pip"], ["-m", "pip"]]
    assert machine[1][-3:] == ["--no-deps", "-r", "requirements/session.txt"]


@pytest.mark.parametrize(
    "name, minor, expected",
    [
        ("session", 13, "The session environment requires Python 3.11 to 3.12"),
        ("pilot", 14, "The pilot environment requires Python 3.11 to 3.13"),
        ("pilot", 10, "The pilot environment requires Python 3.11 to 3.13"),
        ("everything", 12, "'everything' is not a set; expected one of: pilot, session, test."),
    ],
)
def test_a_python_or_a_set_that_is_not_supported_is_refused(
    monkeypatch, capsys, name, minor, expected
):
    monkeypatch.setattr(sys, "version_info", (3, minor, 0, "final", 0))
    monkeypatch.setattr(setup, "install", None)  # is not reached
    assert setup.main(name) == 1
    assert capsys.readouterr().err.startswith(expected)
