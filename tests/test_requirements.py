"""What a command needs is checked before it starts to work; the remedy is named."""

from __future__ import annotations

import os
import subprocess
import sys
from argparse import Namespace
from dataclasses import fields
from pathlib import Path

import pytest

from slipscale import commands, requirements
from slipscale.experiments.journal.header import header
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.lab.defaults import Defaults
from slipscale.experiments.running.lab_session import make_plan
from slipscale.faults import UserError
from slipscale.faults.extras import EXTRA_OF
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.plate_file import Identity, Wiring, new_plate
from slipscale.hardware.registry import open_plate
from slipscale.requirements import NEEDS, WITHOUT_OUT, WRITES, check, unwritable
from tools.site import command_reference

#: Runs a command where some modules cannot be imported; what was imported is printed at the end.
HIDDEN = """
import sys
for name in sys.argv[1].split(","):
    sys.modules[name] = None
from slipscale import commands
status = commands.main(sys.argv[2:])
work = ("slipscale.analysis.pipeline", "slipscale.experiments.session.session", "pandas")
print("worked" if any(map(sys.modules.get, work)) else "checked", file=sys.stderr)
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


def begun(folder, spec, answered_by):
    """Write the journal of a run that was interrupted at once; return its path."""
    plan = make_plan("biet2007", participant="01", pilot=True)
    path, clock = plan.journal_path(folder), VirtualClock()
    contact = {"force": {"spec": "load_cells:COM2"}}
    with open_plate("mock", clock=clock) as plate, Journal.create(path, clock) as journal:
        journal.write("header", **header(plan, plate, spec, answered_by, "absent"), contact=contact)
        journal.write("markers", outputs=["lsl"])
    return path


@pytest.mark.parametrize(
    "run, words, needed",
    [
        (("mock", "simulated"), ("--markers", "parallel:0"), {"serial"}),
        (("mock", "person"), (), {"psychopy", "serial", "pylsl"}),
        (
            ("mock", "person"),
            ("--force", "none", "--markers", "serial:COM1"),
            {"psychopy", "serial"},
        ),
        (("scpi:X", "person"), ("--force", "daq"), {"psychopy", "pyvisa", "pylsl", "nidaqmx"}),
        (("scpi:X", "simulated"), ("--plate", "sound:1"), {"serial", "pylsl", "sounddevice"}),
    ],
)
def test_resume_needs_what_the_run_used_unless_the_command_line_names_another(
    tmp_path, monkeypatch, run, words, needed
):
    path = begun(tmp_path, *run)
    args = commands.load_command("resume")[0].parse_args([str(path), *words])
    asked = set()
    monkeypatch.setattr(requirements, "is_installed", lambda module: asked.add(module) or True)
    check("resume", args)
    assert asked == needed


def test_resume_reports_a_missing_package_before_the_journal_is_written(
    tmp_path, monkeypatch, capsys
):
    path = begun(tmp_path, "serial:COM9", "person")
    before = path.read_bytes()
    monkeypatch.setattr(requirements, "is_installed", lambda module: module != "serial")
    assert commands.main(["resume", str(path)]) == 2
    said = capsys.readouterr().err
    assert said.startswith("slipscale resume: needs the package 'serial'")
    assert "pip install 'slipscale[plate]'" in said
    assert path.read_bytes() == before


def test_next_checks_the_devices_and_places_of_the_laboratory_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").write_text("a file")
    (tmp_path / "slipscale.toml").write_text(
        'study = "biet2007"\nplate = "scpi:X"\nmarkers = ["lsl"]\nforce = "daq"\n'
        'backup = "full/backup"\npilots = "full/pilots"\n'
    )
    args = commands.load_command("next")[0].parse_args(["--pilot"])
    monkeypatch.setattr(requirements, "is_installed", lambda _: False)
    with pytest.raises(UserError) as raised:
        check("next", args)
    said = str(raised.value).split("; ")
    found = {extra for extra in EXTRA_OF.values() if f"'slipscale[{extra}]'" in str(raised.value)}
    assert found == {"plate", "markers", "daq", "session"}
    assert "full/pilots/rehearsals: full is a file" in said
    assert "full/backup: full is a file" in said


STUDY = """name = "mine"
title = "Mine"
amplitudes_um_pp = [0.0, 1.2]
[plate]
{sources}
[[tasks]]
protocol = "magnitude_estimation"
"""
#: What the study names, what the command line adds -> the modules that measure the finger.
SOURCES = [
    ('position = "lasers"\nforce = "daq"', (), {"serial", "nidaqmx"}),
    ('position = "lasers"', ("--force", "daq"), {"serial", "nidaqmx"}),
    ('force = "load_cells"', ("--force", "daq"), {"nidaqmx"}),
    ('force = "daq"', ("--force", "none"), set()),
    ('file = "desk"', (), {"serial", "nidaqmx"}),
    ('file = "desk"\nforce = "simulated"', (), {"serial"}),
    ("", ("--plate", "mock:q=50,plate=desk"), {"serial", "nidaqmx"}),
]


@pytest.fixture
def modules_of(tmp_path, monkeypatch):
    """Return a function from a command line to the modules that it is checked for.

    In the folder is a plate file that names a position and a force.
    """
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plates").mkdir()
    wiring = Wiring(backend="mock", position="lasers:COM1", force="daq")
    new_plate(Identity(name="desk"), wiring, tmp_path / "plates/desk.toml")
    asked = set()
    monkeypatch.setattr(requirements, "is_installed", lambda module: asked.add(module) or True)

    def run(command, *words):
        check(command, commands.load_command(command)[0].parse_args(words))
        return asked - {"psychopy", "sounddevice"}

    return run


@pytest.mark.parametrize("sources, words, needed", SOURCES)
@pytest.mark.parametrize("command", ["run", "check"])
def test_what_the_study_or_the_plate_file_names_is_needed_too(
    modules_of, command, sources, words, needed
):
    Path("mine.toml").write_text(STUDY.format(sources=sources))
    assert modules_of(command, "mine.toml", "--participant", "01", *words) == needed


def test_next_needs_what_its_folders_study_and_plate_file_name(modules_of):
    Path("mine.toml").write_text(STUDY.format(sources='force = "load_cells"'))
    Path("slipscale.toml").write_text('study = "mine.toml"\nplate = "scpi:X,plate=desk"\n')
    assert modules_of("next") == {"pyvisa", "serial"}


def test_a_port_that_may_not_be_opened_is_named_before_the_first_question(tmp_path, monkeypatch):
    port = tmp_path / "ttyACM0"
    port.touch()
    monkeypatch.setattr(os, "access", lambda path, _mode: Path(path) != port)
    words = ["--participant", "01", "--plate", f"serial:{port},q=50", "--out", str(tmp_path)]
    args = commands.load_command("run")[0].parse_args(words)
    with pytest.raises(UserError, match=f"no permission to open {port}. On Linux, join the group"):
        check("run", args)


#: `check` reports them as findings; `lab init` writes nothing but the folder itself.
NOT_CHECKED = {("check", "out"), ("check", "backup"), ("lab init", "backup")}


def test_every_option_that_names_what_is_written_is_checked():
    written = {"out", "backup", "html", "figure", "cache"}
    options = {
        (prog.removeprefix("slipscale "), action.dest)
        for prog, parser in command_reference.parsers().items()
        for action in command_reference.arguments(parser)
        if action.dest in written
    }
    assert len(options) > 15
    checked = {(command, option) for command, names in WRITES.items() for option in names}
    assert options - NOT_CHECKED <= checked


def test_a_run_in_a_folder_without_permission_is_not_resumed(tmp_path, monkeypatch):
    path = begun(tmp_path, "mock", "simulated")
    monkeypatch.setattr(os, "access", lambda place, _mode: Path(place) != path)
    args = commands.load_command("resume")[0].parse_args([str(path)])
    with pytest.raises(UserError, match=r"no permission to write to .*journal\.jsonl"):
        check("resume", args)


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


@pytest.mark.usefixtures("figures_and_models_left_out")
def test_an_export_without_word_needs_no_word_package(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "docx", None)
    table, out = tmp_path / "tidy.csv", tmp_path / "o"
    table.write_text(TIDY, encoding="utf-8")
    assert commands.main(["export", str(table), "--out", str(out), "--forms", "methods"]) == 0
    assert (out / "methods.md").is_file()


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
        f"slipscale {words[0]}: --out tidy.csv/results: tidy.csv is a file; name a folder\n"
    )


def test_a_folder_without_permission_is_named(tmp_path, monkeypatch):
    """`os.access` answers as on a folder of another user, since root may write everywhere."""
    monkeypatch.setattr(os, "access", lambda path, _mode: Path(path) != tmp_path)
    assert unwritable(tmp_path / "new" / "deep") == (
        f"no permission to write to {tmp_path}; change its permissions, or name another folder"
    )
    assert unwritable(Path(__file__)) == ""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UserError, match="no permission to write to"):
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
        if need.command in ("next", "resume"):  # the laboratory folder and the journal say more
            assert need.option in {"", "answered_by", *(field.name for field in fields(Defaults))}
        elif need.option and " " not in need.command:
            assert f"--{need.option}" in parsers[need.command].format_help()
