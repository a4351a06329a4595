"""The command that installs what sessions require."""

import re
import shlex
import sys

import pytest

from slipscale import commands
from slipscale.experiments.cli import setup

PIP = [sys.executable, "-m", "pip", "install", "--no-deps", "-r", str(setup.PINS)]
UV = ["/bin/uv", "pip", "install", "--python", sys.executable, "--no-deps", "-r", str(setup.PINS)]


@pytest.fixture
def present(monkeypatch):
    """Return a function that makes only the named installers available, and what was started."""
    started = []

    class Done:
        returncode = 0

    def make(*names, python=(3, 12, 1), status=0):
        Done.returncode = status
        monkeypatch.setattr(sys, "version_info", python)
        monkeypatch.setattr(
            setup.shutil, "which", lambda name: f"/bin/{name}" if name in names else None
        )
        monkeypatch.setattr(setup, "find_spec", lambda name: name in names or None)
        monkeypatch.setattr(
            setup.subprocess, "run", lambda words, **_: started.append(words) or Done
        )
        return started

    return make


@pytest.mark.parametrize(
    "installers, shown",
    [(("pip",), [PIP]), (("uv",), [UV]), (("uv", "pip"), [UV, PIP])],
)
def test_the_commands_of_the_installers_that_are_there_are_shown(
    present, capsys, installers, shown
):
    assert present(*installers) == []
    assert commands.main(["setup", "session"]) == 0
    assert [shlex.split(line) for line in capsys.readouterr().out.splitlines()] == shown


@pytest.mark.parametrize("status, answer", [(0, 0), (1, 1)])
def test_run_starts_the_first_installer_and_answers_whether_it_succeeded(present, status, answer):
    started = present("uv", "pip", status=status)
    assert commands.main(["setup", "session", "--run"]) == answer
    assert started == [UV]


def test_without_an_installer_or_with_a_python_that_psychopy_lacks_nothing_is_started(
    present, capsys
):
    started = present()
    assert commands.main(["setup", "session", "--run"]) == 2
    assert "neither pip nor uv is available" in capsys.readouterr().err
    present("uv", "pip", python=(3, 13, 0))
    assert commands.main(["setup", "session", "--run"]) == 2
    assert "no release for Python 3.13; install Slipscale with Python 3.11 or 3.12" in (
        capsys.readouterr().err
    )
    assert started == []


def test_the_pins_name_psychopy_by_hash_and_no_index():
    text = setup.PINS.read_text(encoding="utf-8")
    assert re.search(
        r"(?m)^psychopy==\S+ ; python_full_version < '3.13' \\\n    --hash=sha256:", text
    )
    assert "://" not in text
    assert not re.search(r"(?m)^(pyqt6|opencv-python|gevent)==", text)
