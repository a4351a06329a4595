import json
import subprocess
import sys

import pytest
from serial.tools.list_ports_common import ListPortInfo

from slipscale import commands
from slipscale.hardware.cli.plate import SUBCOMMANDS
from slipscale.hardware.cli.ports import as_text, listing
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.surface import VirtualSurface


def port(device, description, serial_number):
    info = ListPortInfo(device)
    info.description, info.serial_number = description, serial_number
    return info


def test_ports_are_listed_with_the_spec_that_opens_them():
    found = listing(["mock", "serial"], lambda: [port("/dev/ttyACM0", "Arduino Uno", "7583")])
    assert found["ports"][0]["spec"] == "serial:/dev/ttyACM0"
    assert "--plate serial:/dev/ttyACM0  Arduino Uno 7583" in as_text(found)


def test_without_ports_the_list_says_what_to_do():
    assert "plate emulate" in as_text(listing(["mock"], list))


def test_the_list_names_every_backend(capsys):
    assert commands.main(["plate", "list", "--json"]) == 0
    names = [each["name"] for each in json.loads(capsys.readouterr().out)["backends"]]
    assert {"mock", "serial", "scpi"} <= set(names)


@pytest.mark.parametrize("name", [name for name in SUBCOMMANDS if name != "design"])
def test_every_subcommand_has_help(name, capsys):
    with pytest.raises(SystemExit) as caught:
        commands.main(["plate", name, "--help"])
    assert caught.value.code == 0
    assert f"usage: slipscale plate {name}" in capsys.readouterr().out


def test_an_unknown_subcommand_is_the_users_fault(capsys):
    assert commands.main(["plate", "polish"]) == 2
    assert "unknown subcommand 'polish', expected one of list, new" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [["--fault", "gremlin"], ["--fault", "unplug@lunch/2"], ["--fault", "unplug@present/0"]],
)
def test_an_emulator_fault_that_does_not_exist_is_the_users_fault(words, capsys):
    assert commands.main(["plate", "emulate", *words]) == 2
    assert "expected FAULT" in capsys.readouterr().err


def test_the_front_door_loads_nothing_heavy_for_help():
    code = (
        "import sys; from slipscale import commands\n"
        "try: commands.main(['plate', '--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'numpy', 'scipy', 'matplotlib', 'serial', 'pydantic', 'psychopy'}\n"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"


def test_a_log_never_overwrites_what_is_there(tmp_path, capsys):
    log = tmp_path / "plate.csv"
    log.write_text("mine")
    assert commands.main(["plate", "emulate", "--log", str(log)]) == 2
    assert "plate.csv: File exists" in capsys.readouterr().err
    assert log.read_text() == "mine"


def test_the_emulator_is_controlled_line_by_line(emulate):
    board = emulate("--seed", "3")
    assert board.state()["state"] == "OFF"
    with pytest.raises(ValueError, match="expected FAULT"):
        board.fault("gremlin")
    assert board.unplug()["plugged"] is False


def test_faults_on_order_can_be_forgotten(host):
    board = host.plug_in()
    board.fault("unplug@present")
    board.no_faults()
    with open_plate(f"serial:{board.port}", clock=host) as plate:
        plate.present(VirtualSurface(level=1.0))
    assert board.state()["presented_levels"] == [1.0]


def test_a_board_comes_back_when_told(host):
    board = host.plug_in("--back-after", "0")
    assert board.unplug()["plugged"] is False
    assert board.back()["plugged"] is True
    with open_plate(f"serial:{board.port}", clock=host) as plate:
        plate.present(VirtualSurface(level=1.0))


@pytest.mark.parametrize("options", [[], ["--firmware"]])
def test_an_emulated_board_has_the_watchdog_that_was_wanted(host, options):
    board = host.plug_in("--watchdog", "1200", *options)
    with open_plate(f"serial:{board.port}", clock=host) as plate:
        assert plate.watchdog_s == 1.2


def test_a_watchdog_that_no_board_may_have_is_refused(capsys):
    assert commands.main(["plate", "emulate", "--watchdog", "50"]) == 2
    assert "--watchdog: 50, expected 400 to 2000 ms" in capsys.readouterr().err
