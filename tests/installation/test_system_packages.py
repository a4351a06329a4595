"""The system packages that tests need: installed if possible, otherwise named with the command."""

import pytest

from tools import system_packages


class Machine:
    """A Debian on which some packages are installed and some cannot be had."""

    def __init__(self, installed, offered):
        self.installed, self.offered = set(installed), set(offered)

    def missing(self, packages):
        return [name for name in packages if name not in self.installed]

    def quietly(self, command):
        if command[0] == "apt-cache":
            return int(command[-1] not in self.offered)
        if "install" in command:
            self.installed |= self.offered & set(command)
        return 0


@pytest.fixture
def machine(monkeypatch):
    def make(installed=(), offered=(), privilege=()):
        made = Machine(installed, offered)
        monkeypatch.setattr(system_packages.sys, "platform", "linux")
        monkeypatch.setattr(system_packages.sys, "argv", ["system_packages.py"])
        monkeypatch.setattr(system_packages.shutil, "which", lambda name: f"/usr/bin/{name}")
        monkeypatch.setattr(system_packages, "missing", made.missing)
        monkeypatch.setattr(system_packages, "_quietly", made.quietly)
        monkeypatch.setattr(system_packages, "privilege", lambda: privilege)
        return made

    return make


EVERY = {*system_packages.WINDOW, *system_packages.TESTS}


def test_all_that_is_missing_is_installed(machine):
    made = machine(installed=system_packages.WINDOW, offered=EVERY, privilege=[])
    assert system_packages.main() == 0
    assert made.installed == EVERY


def test_a_package_that_the_distribution_lacks_is_named_and_no_error(machine, capsys):
    made = machine(offered=EVERY - {"chromium"}, privilege=[])
    assert system_packages.main() == 0
    assert made.installed == EVERY - {"chromium"}
    assert "apt offers no chromium: tests that need it are skipped." in capsys.readouterr().out


def test_without_the_right_to_install_the_command_is_printed(machine, capsys):
    machine(installed=EVERY - {"xvfb", "openssl"}, privilege=None)
    assert system_packages.main() == 1
    said = capsys.readouterr().err
    assert "sudo apt-get install -y --no-install-recommends xvfb openssl\n" in said
