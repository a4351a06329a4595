"""The front door: grouped help, an example of each command, completion, streams."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys

import pytest

from slipscale import commands
from slipscale.faults.parser import Parser
from slipscale.hardware.cli import plate

#: Examples that need no person, no instrument and no minutes, in an order that works.
QUICK = [
    "slipscale data verify data",
    "slipscale data build data",
    "slipscale data merge data other-data --out merged",
    "slipscale lab init our-lab --study matching",
    "slipscale plate calibrate --plate mock --by Ada --instrument vibrometer",
    "slipscale plate list",
    "slipscale plate new plates/desk.toml --backend serial",
    "slipscale plate sign plates/desk.toml",
    "slipscale reconstruct biet2007_table3",
    "slipscale study new ours.toml --title Ours --license CC0-1.0",
    "slipscale study schema",
    "slipscale study show matching --timeline --people 20",
    "slipscale study texts matching --language de --out texts.de.toml",
    "slipscale study validate matching",
]


def walk(parser):
    """Yield a parser and those of its subcommands."""
    parser.load()
    yield parser
    for action in parser._actions:
        if isinstance(action.choices, dict):
            for inner in action.choices.values():
                yield from walk(inner)


PARSERS = {
    each.prog: each for name in commands.COMMANDS for each in walk(commands.load_command(name)[0])
}


def example_of(parser):
    return parser.epilog.removeprefix("example: ")


def test_no_command_is_a_mistake_and_the_version_has_a_short_option(capsys):
    assert commands.main([]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("usage: slipscale")
    assert commands.main(["-V"]) == commands.main(["--version"]) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert first == second


def test_help_shows_every_command_once_in_its_group(capsys):
    assert commands.main(["--help"]) == 0
    lines = capsys.readouterr().out.splitlines()
    for title, group in commands.GROUPS.items():
        start = lines.index(f"{title}:") + 1
        assert [line.split()[0] for line in lines[start : start + len(group)]] == list(group)


@pytest.mark.parametrize("prog", PARSERS)
def test_the_help_of_every_command_ends_with_an_example_that_it_accepts(prog, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    parser = PARSERS[prog]
    example = example_of(parser)
    assert parser.format_help().endswith(f"\n\nexample: {example}\n")
    assert "--verbose" in parser.format_help()
    assert example.startswith(prog)
    name, *words = shlex.split(example)[1:]
    assert commands.load_command(name)[0].parse_args(words)


def test_examples_work_one_after_another_in_a_new_folder(tmp_path, monkeypatch, capsys):
    assert set(QUICK) <= {example_of(parser) for parser in PARSERS.values()}
    monkeypatch.chdir(tmp_path)
    assert commands.main(["pilot", "matching", "--participants", "1", "--out", "data"]) == 0
    shutil.copytree("data", "other-data")
    for example in QUICK:
        assert commands.main(shlex.split(example)[1:]) == 0, (example, capsys.readouterr().err)


def test_every_subcommand_of_the_plate_has_an_example():
    assert set(plate.EXAMPLES) == set(plate.SUBCOMMANDS)


@pytest.mark.parametrize(
    "line, completed",
    [
        ("slipscale p", {"pilot", "power", "plate", "participants"}),
        ("slipscale plate ca", {"calibrate"}),
        ("slipscale plate calibrate --pr", {"--prompt"}),
        ("slipscale analyse table.csv --normalise sc", {"scale_top"}),
        ("slipscale study va", {"validate"}),
    ],
)
def test_the_shell_completes_commands_options_and_values(tmp_path, line, completed):
    answer = tmp_path / "answer"
    asked = {
        **os.environ,
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_IFS": "\n",
        "_ARGCOMPLETE_SUPPRESS_SPACE": "1",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(answer),
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
        "COMP_TYPE": "9",
    }
    subprocess.run([sys.executable, "-m", "slipscale"], env=asked, cwd=tmp_path, check=False)
    assert set(answer.read_text(encoding="utf-8").split("\n")) == completed


def test_help_loads_neither_argparse_nor_the_completion():
    code = (
        "import sys; from slipscale import commands; commands.main(['--help']); "
        "print([name for name in ('argparse', 'argcomplete', 'logging') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_verbose_reports_what_is_read_and_chosen_and_when(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert commands.main(["plate", "watch", "mock", "--seconds", "0.01", "--verbose"]) == 0
    said = capsys.readouterr()
    assert "chose backend mock" in said.err
    assert " s  slipscale.commands: plate ended" in said.err
    assert "chose" not in said.out


def test_a_subcommands_errors_name_its_own_help():
    parser = Parser(prog="slipscale x")
    parser.add_subparsers(dest="what", metavar="a | b", required=True).add_parser("a")
    with pytest.raises(commands.UserError, match=r"expected a subcommand: a; .*slipscale x --help"):
        parser.parse_args([])
    with pytest.raises(commands.UserError, match="unexpected argument 'spare'"):
        parser.parse_args(["a", "spare"])


WRAPS_A_SIGNAL = """
import os, signal, sys
from slipscale import commands
def answer(_):
    try:
        os.kill(os.getpid(), signal.SIGTERM)
    except KeyboardInterrupt:
        raise ValueError("a library makes another error of it") from None
commands._answer = answer
sys.argv = ["slipscale"]
sys.exit(commands.main())
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals are POSIX'")
def test_a_signal_that_a_library_makes_another_error_of_ends_quietly():
    ended = subprocess.run(
        [sys.executable, "-c", WRAPS_A_SIGNAL], capture_output=True, text=True, check=False
    )
    assert (ended.returncode, ended.stderr) == (130, "")


@pytest.mark.parametrize("before, after", [({}, "1"), ({"OPENBLAS_NUM_THREADS": "4"}, "4")])
def test_a_command_computes_on_one_thread_unless_told_otherwise(before, after):
    about = {key: value for key, value in os.environ.items() if key != "OPENBLAS_NUM_THREADS"}
    script = (
        "import os, sys; from slipscale import commands; sys.argv[1:] = ['--version'];"
        "commands.main(); print(os.environ['OPENBLAS_NUM_THREADS'])"
    )
    said = subprocess.check_output([sys.executable, "-c", script], env=about | before, text=True)
    assert said.split()[-1] == after


@pytest.mark.skipif(sys.platform == "win32", reason="locales of POSIX")
@pytest.mark.parametrize("options", [(), ("-X", "utf8=0")])
def test_files_are_read_as_utf_8_in_any_locale_and_the_terminal_keeps_its_encoding(options):
    about = os.environ | {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    script = (
        "import sys; from slipscale import commands; sys.argv[1:] = ['--version'];"
        "commands.main(); import codecs;"
        "print(sys.flags.utf8_mode, codecs.lookup(sys.stdout.encoding).name)"
    )
    said = subprocess.check_output([sys.executable, *options, "-c", script], env=about, text=True)
    # An option of Python is stronger than the environment.
    assert said.split()[-2:] == ["0" if options else "1", "ascii"]
