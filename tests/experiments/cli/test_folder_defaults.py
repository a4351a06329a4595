"""In a laboratory folder every command takes its defaults from slipscale.toml, and says so."""

import argparse
from dataclasses import astuple
from pathlib import Path

import pytest

from slipscale.commands import COMMANDS, load_command, main
from slipscale.experiments.cli import session_options
from slipscale.experiments.lab.folder import FILE
from slipscale.experiments.running import lab_session, preflight
from slipscale.faults import DONE
from slipscale.hardware.cli import plate

pytestmark = pytest.mark.usefixtures("without_models")

LAB = """
study = "gone.toml"
plate = "serial:/dev/nowhere,calibration=gone-too.toml"
data = "trials"
pilots = "tries"
"""
PORT, STUDY, DATA = "/dev/nowhere", "gone.toml", "trials"
# What a command is given here besides, and the value of the folder that its answer must name.
TAKES = {
    "pilot": ([], STUDY),
    "run": (["--participant", "01"], STUDY),
    "lab": (["--no-browser"], STUDY),
    "next": ([], STUDY),
    "participants": ([], STUDY),
    "note": (["the heating came on"], DATA),
    "data build": ([], DATA),
    "data verify": ([], DATA),
    "data withdraw": (["--participant", "01"], DATA),
    "analyse": ([], DATA),
    "export": (["--out", "out"], DATA),
    "power": ([], STUDY),
    "study show": ([], STUDY),
    "study validate": ([], STUDY),
    "study freeze": (["--out", "plan"], STUDY),
    "study texts": (["--language", "de", "--out", "texts.de.toml"], STUDY),
    "plate watch": ([], "gone-too.toml"),
    "plate conform": ([], PORT),
    "plate calibrate": (["--by", "me", "--instrument", "a vibrometer"], PORT),
}
# Looked at below: they need a journal, or a window.
APART = {"resume", "check"}
# They are about files that are named, or about nothing that a folder knows.
NOTHING_TO_TAKE = {
    *("lab init", "data merge", "reproduce", "reconstruct", "study new", "study schema"),
    *("plate list", "plate new", "plate sign", "plate emulate", "plate design"),
    "setup session",
}


def commands():
    """Return the words of every command, of all wings."""
    for name in COMMANDS:
        parser, _ = load_command(name)
        parts = [a for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
        below = plate.SUBCOMMANDS if name == "plate" else [w for a in parts for w in a.choices]
        yield from (f"{name} {word}" for word in below)
        if name == "lab" or not below:
            yield name


def test_of_every_command_it_is_known_what_it_takes():
    known = [*TAKES, *APART, *NOTHING_TO_TAKE]
    assert sorted(known) == sorted(commands())


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / FILE).write_text(LAB)
    return tmp_path


@pytest.mark.parametrize("command", TAKES)
def test_a_command_takes_the_folders_defaults_and_says_which_file_that_was(folder, capsys, command):
    words, named = TAKES[command]
    assert main([*command.split(), *words]) != DONE
    said = capsys.readouterr()
    assert said.err.startswith(f"defaults: {folder / FILE}\n")
    assert said.err.count("defaults: ") == 1
    assert named in said.out + said.err.partition("\n")[2]


WHOLE = """
plate = "serial:COM9"
screen = 1
windowed = true
language = "fr"
markers = ["lsl"]
position = "lasers:COM1"
force = "load_cells:COM2"
sound_required = true
data = "trials"
pilots = "tries"
backup = "elsewhere"
"""
SETTING = {
    "plate": "serial:COM9",
    "screen": 1,
    "full_screen": False,
    "markers": ("lsl",),
    "sound_required": True,
    "backup": Path("elsewhere"),
}


@pytest.mark.parametrize("words", [["run", "--participant", "01"], ["next", "--yes"]])
def test_a_session_takes_every_key(folder, capsys, monkeypatch, words):
    begun = []
    monkeypatch.setattr(lab_session, "begin", lambda *given, **_: begun.append(given) or "complete")
    (folder / FILE).write_text(WHOLE)
    assert main(words) == DONE
    [(out, plan, setting)] = begun
    assert {key: getattr(setting, key) for key in SETTING} == SETTING
    assert astuple(setting.contact) == ("lasers:COM1", "load_cells:COM2")
    assert (out, plan.language) == (Path("trials"), "fr")
    assert "defaults: " in capsys.readouterr().err


def test_check_takes_every_key(folder, capsys, monkeypatch):
    planned = []
    monkeypatch.setattr(preflight, "check", lambda asked, _, **__: planned.append(asked) or [])
    (folder / FILE).write_text(WHOLE)
    assert main(["check"]) == DONE
    [asked] = planned
    assert {key: getattr(asked, key) for key in SETTING} == SETTING
    assert astuple(asked.contact) == ("lasers:COM1", "load_cells:COM2")
    assert (asked.out, asked.language) == (Path("trials"), "fr")
    assert "defaults: " in capsys.readouterr().err


def test_what_goes_on_takes_the_place_it_goes_on_in(folder, capsys, monkeypatch, record_runs):
    [journal] = record_runs(folder / "trials", "01", mode="participant").rglob("*_journal.jsonl")
    journal.write_bytes(b"".join(journal.read_bytes().splitlines(keepends=True)[:40]))
    settings = []
    monkeypatch.setattr(lab_session, "go_on", lambda _, on: settings.append(on) or "complete")
    (folder / FILE).write_text(WHOLE)
    monkeypatch.setattr(
        "slipscale.experiments.journal.plan_and_progress.answered_by", lambda _: "person"
    )
    assert main(["resume", str(journal)]) == DONE
    [setting] = settings
    # The plate and the recorders are those of the run itself.
    assert {key: getattr(setting, key) for key in ("screen", "full_screen", "backup")} == {
        key: SETTING[key] for key in ("screen", "full_screen", "backup")
    }
    assert "defaults: " in capsys.readouterr().err


def test_a_calibration_is_made_without_the_one_before(folder, capsys):
    """Otherwise the first could never be made: the folder names the file that it will be."""
    words = ["plate", "calibrate", "--by", "me", "--instrument", "a vibrometer"]
    main(words)
    assert "gone-too.toml" not in capsys.readouterr().err


def test_an_emulated_board_is_not_the_folders_plate(folder, capsys):
    assert main(["plate", "emulate", "--fault", "nonsense"]) == 2
    assert "--fault: expected FAULT" in capsys.readouterr().err


def test_a_pilot_simulates_what_the_laboratory_measures(folder, monkeypatch):
    """Its plate and its finger exist nowhere: a laser on a port could tell it nothing."""
    (folder / FILE).write_text(WHOLE)
    parser, _ = load_command("pilot")
    contact = session_options.simulated_contact(parser.parse_args([]))
    assert astuple(contact) == ("simulated", "simulated")
    named = parser.parse_args(["--position", "none"])
    assert astuple(session_options.simulated_contact(named)) == ("none", "simulated")


def test_without_a_folder_a_plate_that_vibrates_must_be_named(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for word in ("watch", "conform"):
        assert main(["plate", word]) == 2
        said = capsys.readouterr().err
        assert "expected" in said
        assert "defaults" not in said
