"""docs/tutorials/first-day.md, followed command by command in a scratch directory."""

import re
import shlex
import shutil
import sys
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pandas as pd
import pytest

from slipscale import commands
from tests.support.session_window import SessionWindow

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "tutorials" / "first-day.md"
BLOCK = re.compile(r"^```(\w+)(?: (\S+))?\n(.*?)^```", re.MULTILINE | re.DOTALL)

pytestmark = [
    pytest.mark.window,
    pytest.mark.skipif(
        not sys.platform.startswith("linux") or not shutil.which("xdotool"),
        reason="key presses come from xdotool, under X11",
    ),
]


def follow(words, folder):
    """Run a command of the page: a session in its own process, others in this one."""
    if words[1] != "run":
        with redirect_stdout(StringIO()) as printed:
            assert commands.main(words[1:]) == 0, words
        return printed.getvalue()
    with SessionWindow(*words[1:], folder=folder) as participant:
        while step := participant.next_step():
            participant.answer(step)
        status, said, complaint = participant.end()
    assert status == 0, f"{words}\n{said}\n{complaint}"
    return said


def values(figure):
    """Return the values that a figure shows under the pointer."""
    return re.findall(r"<title>.*?</title>", figure.read_text(encoding="utf-8"))


def test_the_page_followed_literally_leads_to_a_report(display, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert "\t@$(BIN)/slipscale pilot $(ARGS)\n" in makefile
    said = ""
    for language, name, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        if language == "sh":
            for line in text.splitlines():
                command = "slipscale pilot" if line == "make pilot" else line
                said = follow(shlex.split(command), tmp_path)
        elif name.startswith("file="):
            (tmp_path / name.removeprefix("file=")).write_text(text, encoding="utf-8")
        else:
            printed = {tuple(line.split()) for line in said.splitlines()}
            assert {tuple(line.split()) for line in text.splitlines()} <= printed
    reports = "pilots/001", "pilots/mine", "my-data"
    assert all((tmp_path / each / "derivatives/slipscale/report.html").exists() for each in reports)
    # README's picture is what its first command writes; to write it again: make pictures
    pilot = tmp_path / "pilots/001/derivatives/slipscale/fig15.svg"
    assert values(pilot) == values(ROOT / "docs/images/fig15.svg")
    assert "<title>1.2 µm: arithmetic mean 56.17</title>" in values(pilot)
    answered = pd.read_csv(tmp_path / "my-data/derivatives/slipscale/estimates.csv")
    assert list(answered["estimate"]) == [12.5] * 3
