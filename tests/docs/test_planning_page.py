"""docs/how-to/planning.md, followed by command: fewer people, fewer studies."""

from pathlib import Path

import pytest

from slipscale.commands import main
from tools.planning_pictures import MOST_BYTES, PAGE, PICTURES, commands, made, pictures, study_file

TEXT = PAGE.read_text(encoding="utf-8")
#: Command -> what makes it quick; an option given twice counts as it was given last.
QUICK = {
    "study show": ["--people", "4"],
    "pilot": ["--times", "1", "--participants", "4"],
    "power": ["--participants", "4,6", "--studies", "3"],
    "--catch-steps": ["--participants", "6", "--studies", "3", "--catch-steps", "1:2"],
    "--protocols": [
        *("--minutes", "4", "--participants", "4", "--studies", "1", "--jobs", "1"),
        *("--protocols", "ratio_to_standard", "constant_stimuli"),
    ],
    "--looks": ["--participants", "9", "--studies", "3"],
    "freeze": [],
}


def quick(words):
    """Return a command with the options that make it quick: the last ones that fit."""
    line = " ".join(words)
    fitting = [more for name, more in QUICK.items() if name in line]
    return [*words[1:], *(fitting[-1] if fitting else [])]


@pytest.fixture(scope="module")
def followed(tmp_path_factory):
    """Return the folder in which every command of the page was followed."""
    folder = tmp_path_factory.mktemp("afternoon")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for words in commands(TEXT):
            status = main(quick(words))
            # 1: none of so few people is enough.
            assert status == 0 or (status == 1 and words[1] == "power"), words
            if words[1:3] == ["study", "new"]:
                file = folder / words[3]
                file.write_text(study_file(TEXT, file.read_text("utf-8")), encoding="utf-8")
    return folder


def test_every_command_of_the_page_works_and_makes_its_picture(followed):
    missing = [name for name in pictures(TEXT) if not made(followed, name).is_file()]
    assert missing == []
    assert len(pictures(TEXT)) >= 10


def test_the_twelve_questions_have_a_heading_each():
    assert [f"## {number}. " in TEXT for number in range(1, 13)] == [True] * 12


@pytest.mark.parametrize("name", pictures(TEXT))
def test_the_page_s_pictures_are_there_and_small(name):
    assert Path(PICTURES, name).stat().st_size <= MOST_BYTES
