"""What a new user types wrongly is answered in one line: what, where, expected, what next."""

from __future__ import annotations

import sys

import pytest

from slipscale import commands
from slipscale.experiments.journal.locks import is_being_written
from slipscale.experiments.running import pilot

pytestmark = pytest.mark.usefixtures("without_models")

STUDY = """name = "small"
title = "Small"
amplitudes_um_pp = [0.0, 0.5, 1.0]
[[tasks]]
protocol = "magnitude_estimation"
"""
FILES = {
    "exists.toml": STUDY,
    "key.toml": STUDY.replace("amplitudes_um_pp", "amplitude_um_pp"),
    "quoted.toml": STUDY.replace("0.5", '"0.5"'),
    "quote.toml": STUDY.replace('"small"', '"small'),
    "comma.toml": STUDY.replace("0.0, 0.5, 1.0", "0,5, 1,0, 1,5"),
    "protocol.toml": STUDY.replace("magnitude_estimation", "magnitude_estimaton"),
    "value.toml": STUDY.replace("[[tasks]]", 'task_order = "fixt"\n[[tasks]]'),
    "table.toml": f"{STUDY}repetition = 3\n",
    "columns.csv": "who,what,said\n1,0.5,20\n",
    "tidy.csv": "participant_id,amplitude_um_pp,estimate\n1,0.5,20\n",
}
VALIDATE = ("study", "validate")

#: Number in the list of mistakes, words of the command, what the answer holds, exit status.
MISTAKES = [
    ("1", ("pilto",), ("'pilto'", "did you mean 'slipscale pilot'?", "slipscale --help"), 2),
    ("2", ("run",), ("--participant is missing", "--participant 01", "slipscale run --help"), 2),
    ("2 bare", ("run", "02"), ("did you mean slipscale run --participant 02?",), 2),
    ("2 data", ("data", "withdraw", "01"), ("slipscale data withdraw --participant 01?",), 2),
    ("2 order", ("--participant", "02", "run"), ("slipscale run --participant 02",), 2),
    ("2 short", ("pilot", "-n", "10"), ("unknown option -n (did you mean '--participants'?)",), 2),
    ("2 sub", ("init",), ("'init' is a subcommand: slipscale lab init",), 2),
    ("2 subs", ("new", "x"), ("slipscale plate new or slipscale study new",), 2),
    ("2 lab", ("lab", "start"), ("expected one of init, or slipscale lab alone",), 2),
    ("3", ("run", "--participant", "Anna M"), ("'Anna M'", "such as 01"), 2),
    ("4", ("plate", "watch", "serial:/dev/ttyNO"), ("/dev/ttyNO", "slipscale plate list"), 3),
    ("5", ("run", "--participant", "01", "--plate", "ttyACM0"), ("serial:/dev/ttyACM0",), 2),
    ("5 lab", ("lab", "init", "x", "--plate", "ttyACM0"), ("serial:/dev/ttyACM0",), 2),
    ("6", (*VALIDATE, "matchin"), ("did you mean 'matching'?", "slipscale study new"), 2),
    ("7", ("analyse", "nowhere"), ("nowhere", "expected a data set"), 2),
    ("8", ("analyse", "empty"), ("no data found", "participant_id"), 2),
    ("9", ("analyse", "columns.csv"), ("participant_id", "--participant", "--map"), 2),
    ("11", (*VALIDATE, "key.toml"), ("line 3", "'amplitudes_um_pp'?", "study validate key"), 2),
    ("12", (*VALIDATE, "quoted.toml"), ("item 2 of amplitudes_um_pp", "without quotation"), 2),
    ("13", (*VALIDATE, "quote.toml"), ("line 1", "quotation mark is not closed"), 2),
    ("14", (*VALIDATE, "comma.toml"), ("line 3, amplitudes_um_pp", "0,5", "write 0.5"), 2),
    ("14 protocol", (*VALIDATE, "protocol.toml"), ("line 5", "'magnitude_estimation'?"), 2),
    ("14 value", (*VALIDATE, "value.toml"), ("task_order", "did you mean 'fixed'?"), 2),
    ("14 task", (*VALIDATE, "table.toml"), ("item 1 of tasks", "'repetitions'?"), 2),
    ("15", ("study", "new", "exists.toml"), ("already exists", "a new file"), 2),
    ("16", ("pilot", "--participants", "twelve"), ("'twelve'", "whole number"), 2),
    ("17", ("pilot", "--participants", "0"), ("0", "expected 1 or more"), 2),
    ("18", ("analyse", "tidy.csv", "--normalise", "scale_tpo"), ("mean 'scale_top'?", "--help"), 2),
    ("19", ("power", "--participants", "5-10"), ("5-10", "8:40:4"), 2),
    ("20", ("resume",), ("RUN_JOURNAL is missing", "pilots", "slipscale run"), 2),
    ("21", ("resume", "empty"), ("empty is a folder", "slipscale run"), 2),
    ("22", ("next",), ("no slipscale.toml here", "slipscale lab init"), 2),
    ("23", ("plate", "calibrate"), ("--by and --instrument are missing", "calibrate --help"), 2),
    ("25", ("export", "empty"), ("--out is missing", "--out DIR", "slipscale export --help"), 2),
    ("26", ("data", "withdraw", "run", "--participant", "7"), ("contains no data", "one of 01"), 2),
    ("27", ("note", "cleaned"), ("no session is running",), 2),
    ("28", ("export", "tidy.csv", "--out", "o"), ("pip install 'slipscale[export]'",), 2),
    ("option", ("pilot", "--partcipants", "3"), ("--partcipants", "'--participants'?"), 2),
    ("subcommand", ("data", "bild"), ("'bild'", "did you mean 'build'?"), 2),
    ("unknown subcommand", ("data",), ("subcommand", "build, verify", "data --help"), 2),
]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Start in a new folder with a new user's files, without the package that writes Word."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "docx", None)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "empty").mkdir()
    return tmp_path


def interrupted(folder):
    """Run a pilot into a folder, and cut the end of its journal off; return the journal."""
    plan = next(iter(pilot.pilot_plans("exists.toml", participants=1, seed=1, language=None)))
    pilot.run_simulated(folder, plan, "mock")
    path = plan.journal_path(folder)
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[: len(lines) // 2]))
    assert not is_being_written(path)
    return path


@pytest.mark.parametrize(
    "words, held, status", [row[1:] for row in MISTAKES], ids=[row[0] for row in MISTAKES]
)
def test_a_typical_mistake_is_answered_in_one_line(folder, capsys, words, held, status):
    if words[:2] == ("data", "withdraw"):
        interrupted(folder / "run")
    assert commands.main(list(words)) == status
    said = capsys.readouterr()
    # An unknown table is described first.
    assert said.out == "" or "columns.csv: 1 rows" in said.out
    assert said.err.count("\n") == 1
    assert said.err.startswith("slipscale")
    assert "usage:" not in said.err
    assert "Traceback" not in said.err
    assert [each for each in held if each not in said.err] == []


def test_mistakes_with_two_right_answers_are_accepted(folder, capsys):
    """Tables from French Excel (10), and one name for the study and its table (24)."""
    rows = "".join(f"{who};{a};{10 * who}\n" for who in range(1, 5) for a in ("0,5", "1,5"))
    (folder / "fr.csv").write_text(f"participant_id;amplitude_um_pp;estimate\n{rows}")
    assert commands.main(["analyse", "fr.csv"]) == 0
    assert commands.main(["reconstruct", "biet2007"]) == 0
    assert "0 um" in capsys.readouterr().out


@pytest.mark.parametrize("words", [("resume",), ("resume", "data")])
def test_resume_lists_the_interrupted_runs_that_are_there(folder, capsys, words):
    path = interrupted(folder / "data")
    assert commands.main(list(words)) == 2
    said = capsys.readouterr().err
    assert f"slipscale resume {path.relative_to(folder)}" in said
    assert said.count("\n") == 1


def test_a_mistake_shows_its_traceback_with_verbose_alone(folder, capsys):
    assert commands.main(["study", "validate", "key.toml", "--verbose"]) == 2
    said = capsys.readouterr().err
    assert "Traceback" in said
    assert "read study key.toml" in said
    assert said.endswith("slipscale study validate key.toml\n") or "study ended" in said


def test_an_empty_command_line_of_every_command_is_answered_without_a_usage_dump(folder, capsys):
    for name in ("data", "study", "plate", "export", "run", "reconstruct"):
        assert commands.main([name]) == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1
        assert f"{name} --help" in said


def test_after_a_verbose_command_the_next_one_is_quiet_again(capsys):
    assert commands.main(["study", "validate", "biet2007", "--verbose"]) == 0
    assert " s  slipscale" in capsys.readouterr().err
    assert commands.main(["study", "validate", "biet2007"]) == 0
    assert capsys.readouterr().err == ""


def test_the_commands_with_subcommands_are_those_that_have_some():
    with_some = {name for name in commands.COMMANDS if commands.load_command(name)[0].subcommands}
    assert with_some == set(commands.WITH_SUBCOMMANDS)
