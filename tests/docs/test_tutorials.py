"""Tutorials of protocols, followed command by command, and the pictures that they show.

A pilot is run with one simulated person.
"""

import re
import shlex
from pathlib import Path

import pytest

from slipscale import commands
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
from slipscale.experiments.study.file import study_text
from tools.tutorial_pictures import TUTORIALS, picture_name

pytestmark = pytest.mark.usefixtures("without_models", "without_simulated_fits")

DOCS = Path(__file__).parents[2] / "docs" / "tutorials"
BLOCK = re.compile(r"^```sh\n(.*?)^```", re.MULTILINE | re.DOTALL)
MOST_BYTES = 150_000


def section_of(study):
    """The section of a page that makes a copy of the study."""
    text = (DOCS / f"{TUTORIALS[study].page}.md").read_text(encoding="utf-8")
    (section,) = (each for each in text.split("\n## ") if f"--from {study}\n" in each)
    return section


def run(words, study):
    """Run a command of a page; return its exit status."""
    if words[0] != "pilot":
        return commands.main(words)
    parser, _ = commands.load_command("pilot")
    given = parser.parse_args(words[1:])
    assert given.participants == TUTORIALS[study].participants
    plans = pilot_plans(given.study, participants=1, seed=given.seed, language=given.language)
    run_pilot(given.out, plans, tell=lambda _: None)
    return commands.main(["analyse", str(given.out)])


@pytest.mark.parametrize("study", TUTORIALS)
def test_the_commands_of_a_section_lead_from_a_new_study_to_a_report(
    study, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    commands = [
        shlex.split(line)[1:]
        for block in BLOCK.findall(section_of(study))
        for line in block.split("\n")
        if line
    ]
    assert [words[0] for words in commands][-2:] == ["study", "pilot"]
    for words in commands:
        assert run(words, study) == 0, words
    assert "no fault" in capsys.readouterr().out
    (report,) = tmp_path.rglob("report.html")
    drawn = {path.stem for path in report.parent.glob("*.svg")}
    # The pairs of one person, who is never unsure, have no finite scale.
    assert study == "paired_comparison" or TUTORIALS[study].figure in drawn


@pytest.mark.parametrize("study", TUTORIALS)
def test_a_section_shows_its_pictures_and_they_are_small(study):
    for what in ("screen", "figure") if TUTORIALS[study].screen else ("figure",):
        name = picture_name(study, what)
        assert f"](../images/tutorials/{name})" in section_of(study)
        assert (DOCS.parent / "images" / "tutorials" / name).stat().st_size < MOST_BYTES


@pytest.mark.parametrize("study", TUTORIALS)
def test_the_keys_that_a_section_explains_are_in_its_study(study):
    """A row of the table begins with lines of the study file, or keys of it."""
    rows = re.findall(r"^\| (`.+?) \|", section_of(study), re.MULTILINE)
    keys = {key for row in rows for key in re.findall(r"`(?:\[\w+\] )?(\w+)", row)}
    assert len(keys) > 4
    missing = {key for key in keys if not re.search(rf"\b{key}\b", study_text(study))}
    assert missing == set()
