"""Which files a study names, whatever its keys are called."""

import pytest

from slipscale.analysis.preregistration.named_files import named_files
from slipscale.faults import UserError


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Work in one folder, with the study in another."""
    here, study = tmp_path / "here", tmp_path / "study"
    for each in (here / "plates", study / "words"):
        each.mkdir(parents=True)
    (here / "plates" / "desk.toml").write_text('[calibration]\nfile = "desk.calibration.toml"\n')
    (here / "plates" / "desk.calibration.toml").write_text("made = 1\n")
    (study / "words" / "it.toml").write_text('hello = "ciao"\n')
    (study / "biet").write_text("a file whose name is a word")
    monkeypatch.chdir(here)
    return study


def keys(text, beside):
    return {file.key: file.path.name for file in named_files(text, beside)}


def test_a_plate_by_its_name_and_what_its_file_names(folder):
    assert keys('[plate]\nfile = "desk"\n', folder) == {
        "plate.file": "desk.toml",
        "plate.file > calibration.file": "desk.calibration.toml",
    }


@pytest.mark.parametrize("key", ["texts_file", "a_key_of_tomorrow"])
def test_a_file_beside_the_study_under_any_key(folder, key):
    assert keys(f'{key} = "words/it.toml"\n', folder) == {key: "it.toml"}
    assert keys(f'[[tasks]]\n[tasks.deep]\n{key} = ["words/it.toml"]\n', folder) == {
        f"tasks.1.deep.{key}.1": "it.toml"
    }


@pytest.mark.parametrize(
    "text",
    [
        'name = "biet"',  # a word, though there is such a file
        'title = "Slipperiness, vol. 2"',
        'texts = "nowhere.toml"',
        'long = """two\nlines.toml"""',
        f'long = "{"a" * 5000}.toml"',
        'empty = ""',
    ],
)
def test_words_are_no_files(folder, text):
    assert keys(text, folder) == {}


def test_a_file_that_is_named_twice_is_taken_once(folder):
    text = 'one = "words/it.toml"\ntwo = "words/../words/it.toml"\n'
    assert list(keys(text, folder)) == ["one"]


def test_a_plate_file_that_is_not_there_is_told(folder):
    with pytest.raises(
        UserError, match=r"cannot be read \(.*\); the study's plate\.file names this file"
    ):
        named_files('[plate]\nfile = "bench"\n', folder)
