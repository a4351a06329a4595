"""What a command needs is checked before it starts to work; the remedy is named."""

from __future__ import annotations

import os
import subprocess
import sys
from argparse import Namespace
from pathlib import Path

import pytest

from slipscale import commands
from slipscale.faults import UserError
from slipscale.faults.extras import EXTRA_OF
from slipscale.requirements import NEEDS, WITHOUT_OUT, WRITES, check, unwritable

#: Runs a command where some modules cannot be imported; what was imported is printed at the end.
HIDDEN = """
import sys
for name in sys.argv[1].split(","):
    sys.modules[name] = None
from slipscale import commands
status = commands.main(sys.argv[2:])
print("worked" if "numpy" in sys.modules else "checked", file=sys.stderr)
sys.exit(status)
"""
TIDY = "participant_id,amplitude_um_pp,estimate\n" + "".join(
    f"{who},{amplitude},{10 * who + amplitude}\n" for who in range(1, 5) for amplitude in (1, 2)
)


def without(modules, folder, *words):
    """Run a command in a process of its own, without some modules."""
    (folder / "tidy.csv").write_text(TIDY, encoding="utf-8")
    return subprocess.run(
        [sys.executable, "-c", HIDDEN, modules, *words],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize(
    "modules, words, extra",
    [
        ("docx", ("export", "tidy.csv", "--out", "o"), "export"),
        ("weasyprint", ("export", "tidy.csv", "--out", "o", "--forms", "pdf"), "export"),
        ("pandas", ("pilot", "--out", "o"), "analysis"),
        ("pandas", ("analyse", "tidy.csv", "--out", "o"), "analysis"),
        ("numpyro", ("analyse", "tidy.csv", "--bayesian", "--out", "o"), "bayes"),
        ("distributed", ("power", "--scheduler", "tcp://x:1", "--out", "o"), "cluster"),
        ("serial", ("plate", "list"), "plate"),
        ("serial", ("run", "--participant", "01", "--plate", "serial:COM9"), "plate"),
        ("psychopy", ("run", "--participant", "01", "--out", "o"), "session"),
        ("uvicorn", ("lab", "--no-browser"), "console"),
    ],
)
def test_a_missing_package_is_reported_before_any_work_with_what_installs_it(
    tmp_path, modules, words, extra
):
    done = without(modules, tmp_path, *words)
    sentence, state = done.stderr.splitlines()
    assert (done.returncode, done.stdout, state) == (2, "", "checked")
    assert sentence.startswith(f"slipscale {words[0]}: needs the package '{modules}'")
    assert f"pip install 'slipscale[{extra}]'" in sentence
    assert not (tmp_path / "o").exists()


def test_a_simulated_plate_needs_no_serial_line(tmp_path):
    code = (
        "import sys; sys.modules['serial'] = None\n"
        "import slipscale.experiments.running.lab_session as session\n"
        "print(session.make_plan('matching', participant='01').participant)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=tmp_path
    )
    assert (done.stdout, done.stderr) == ("01\n", "")


def test_an_export_without_word_needs_no_word_package(tmp_path):
    done = without("docx", tmp_path, "export", "tidy.csv", "--out", "o", "--forms", "methods")
    assert done.returncode == 0
    assert (tmp_path / "o" / "methods.md").is_file()


@pytest.mark.parametrize(
    "words",
    [
        ("analyse", "tidy.csv"),
        ("export", "tidy.csv"),
        ("pilot",),
        ("power",),
        ("reproduce",),
        ("reconstruct", "biet2007"),
        ("study", "freeze"),
        ("run", "--participant", "01"),
    ],
    ids=" ".join,
)
def test_an_output_folder_that_cannot_be_made_is_reported_before_any_work(
    tmp_path, monkeypatch, capsys, words
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tidy.csv").write_text(TIDY, encoding="utf-8")
    assert commands.main([*words, "--out", "tidy.csv/results"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == (
        f"slipscale {words[0]}: --out tidy.csv/results: tidy.csv is a file; expected a folder, "
        "name another one\n"
    )


def test_a_folder_without_permission_is_named(tmp_path, monkeypatch):
    """`os.access` answers as on a folder of another user, since root may write everywhere."""
    monkeypatch.setattr(os, "access", lambda path, _mode: Path(path) != tmp_path)
    assert unwritable(tmp_path / "new" / "deep") == (
        f"you may not write to {tmp_path}; name another folder"
    )
    assert unwritable(Path(__file__)) == ""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UserError, match="you may not write to"):
        check("analyse", Namespace(dataset=tmp_path, out=None))


def test_a_missing_program_is_named(monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(UserError, match="needs the program 'cc'"):
        check("plate", Namespace(what="emulate", firmware=True))


def test_the_tables_name_commands_options_and_packages_that_there_are():
    parsers = {name: commands.load_command(name)[0] for name in commands.COMMANDS}
    for command in [*(need.command for need in NEEDS), *WRITES, *WITHOUT_OUT]:
        assert command.split()[0] in parsers
    for need in NEEDS:
        assert set(need.modules) - {"jax"} <= set(EXTRA_OF)
        if need.option and " " not in need.command:
            assert f"--{need.option}" in parsers[need.command].format_help()
