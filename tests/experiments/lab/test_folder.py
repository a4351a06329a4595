"""The laboratory folder: every command in it knows its study, plate and folders."""

import pytest

from slipscale.commands import main
from slipscale.experiments.lab.defaults import REHEARSALS, here
from slipscale.experiments.lab.folder import FILE, LabFile, init, read_lab
from slipscale.faults import UserError


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_new_folder_says_what_was_asked_for_and_explains_every_key(folder):
    given = {"study": "textures_demo", "plate": "serial:COM3", "screen": "1", "windowed": "true"}
    init(folder / "new", given, None)
    lab = read_lab(folder / "new")
    assert (lab.study, lab.plate, lab.screen, lab.windowed) == (
        *("textures_demo", "serial:COM3"),
        *(1, True),
    )
    text = (folder / "new" / FILE).read_text()
    assert all(str(field.description) in text for field in LabFile.model_fields.values())


def test_what_the_command_line_leaves_open_is_asked(folder):
    asked = []

    def answer(question, default):
        asked.append(question)
        return {"Which plate": "serial:COM9"}.get(question[:11], default)

    lab = init(folder, {"study": "textures_demo"}, answer)
    assert (lab.study, lab.plate, lab.data) == ("textures_demo", "serial:COM9", "data")
    assert not any("study?" in question for question in asked)


@pytest.mark.parametrize(
    "given, complaint",
    [
        ({"study": "nothing.toml"}, "nothing.toml.*expected a TOML file"),
        ({"plate": "teapot:1"}, "plate: .*expected one of (daq, )?mock"),
        ({"language": "tlh"}, "language 'tlh': expected one of en, fr"),
        ({"screen": "left"}, "screen.*whole number"),
        ({"screen": "-1"}, "screen"),
        ({"pilots": "data"}, "pilots: expected a folder other"),
        ({"pilots": "./data"}, "pilots: expected a folder other"),
    ],
)
def test_what_cannot_be_used_is_refused_and_nothing_is_written(folder, given, complaint):
    with pytest.raises(UserError, match=complaint):
        init(folder / "new", given, None)
    assert not (folder / "new").exists()


def test_lab_init_makes_a_folder_in_which_commands_work(folder, capsys, monkeypatch):
    words = ["--study", "textures_demo", "--plate", "serial:COM3", "--windowed"]
    assert main(["lab", "init", "mine", *words]) == 0
    assert "study textures_demo, plate serial:COM3" in capsys.readouterr().out
    monkeypatch.chdir(folder / "mine")
    assert (here().plate, here().windowed, here().markers) == ("serial:COM3", True, ())
    assert main(["participants"]) == 0
    assert main(["lab", "init"]) == 2
    assert "already exists" in capsys.readouterr().err


def test_a_folders_markers_and_sources_are_its_sessions(folder):
    (folder / FILE).write_text('markers = ["lsl"]\nposition = "simulated"\n')
    assert (here().markers, here().position, here().force) == (("lsl",), "simulated", None)


def test_a_folder_that_is_one_is_not_overwritten(folder):
    init(folder, {}, None)
    with pytest.raises(UserError, match="already exists"):
        init(folder, {}, None)


def test_outside_a_laboratory_folder_nothing_changes(folder):
    defaults = here()
    assert (defaults.file, defaults.study, defaults.plate) == (None, "biet2007", "mock")
    assert defaults.out(pilot=False) != defaults.out(pilot=True)


def test_in_it_commands_take_their_defaults_and_say_from_where(folder, capsys):
    init(folder, {"study": "textures_demo", "pilots": "trials"}, None)
    assert main(["study", "validate"]) == 0
    said = capsys.readouterr()
    assert "textures_demo: no fault" in said.out
    assert said.err == f"defaults: {folder / FILE}\n"
    assert here().out(pilot=True).parts == ("trials", REHEARSALS)


def test_the_command_line_comes_first(folder, capsys):
    init(folder, {"study": "textures_demo"}, None)
    assert main(["study", "validate", "biet2007"]) == 0
    assert "biet2007: no fault" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["run", "check", "next", "participants", "analyse", "pilot"])
def test_a_fault_in_it_is_one_sentence_in_every_command(folder, capsys, command):
    (folder / FILE).write_text('study = "biet2007"\nplatte = "mock"\n')
    assert main([command]) == 2
    assert "line 2, platte: unknown key" in capsys.readouterr().err


def test_it_counts_only_where_it_lies(folder, monkeypatch):
    init(folder, {"study": "textures_demo"}, None)
    (folder / "below").mkdir()
    monkeypatch.chdir(folder / "below")
    assert here().file is None


def test_the_data_set_need_not_be_named_in_it(folder, capsys, record_runs):
    init(folder, {"data": "mine"}, None)
    record_runs(folder / "mine", "01")
    assert main(["data", "build"]) == 0
    assert "mine: built from its journals (1)" in capsys.readouterr().out
