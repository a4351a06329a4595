"""In a terminal, a command asks what the columns of a table mean."""

import os
import subprocess
import sys

import pandas as pd
import pytest

from slipscale import commands
from slipscale.analysis.cli.asking import meanings
from slipscale.analysis.reading.foreign.proposal import propose
from slipscale.faults import UserError

CODED = pd.DataFrame(
    {
        "who": list("aabb") * 15,
        "size": [1, 2, 4] * 20,
        "other": [3, 5, 7] * 20,
        "outcome": ["hit", "miss", "hit", "late", "hit"] * 12,
    }
)


def replies(*words):
    """Return a function that gives these replies, and the list of prompts."""
    left, prompts = list(words), []

    def ask(prompt):
        prompts.append(prompt)
        return left.pop(0)

    return ask, prompts


def test_what_a_table_does_not_reveal_is_asked_for():
    ask, prompts = replies("7", "size", "2", "outcome", "hti", "hit", "late", "", "mm")
    given = meanings(propose(CODED, [], ["x"]), ask)
    assert given == {
        "participant": "who",
        "stimulus": "size:mm",
        "answer": "outcome",
        "yes": ["hit"],
        "missing": ["late"],
        "no": ["miss"],
    }
    assert "1  size: 1 to 4, 3 values (1, 2, 4)" in prompts[0]
    assert "expected a number from 1 to 2" in prompts[1]  # there is no seventh column
    assert "expected codes from: hit, miss, late" in prompts[5]


def test_a_table_that_reveals_all_but_the_unit_has_two_questions():
    frame = CODED[["who", "size"]].assign(felt=["yes", "no"] * 30)
    ask, prompts = replies("2", "")
    given = meanings(propose(frame, [], ["x"]), ask)
    assert len(prompts) == 2
    assert given == {"participant": "who", "stimulus": "size", "answer": "felt", "alternatives": 2}


def test_counts_are_asked_for_with_both_columns():
    frame = pd.DataFrame({"a": [1, 2, 4, 8], "r": [5, 6, 8, 9], "of": [10, 10, 10, 10]})
    ask, _ = replies("1", "3", "r", "of", "2", "")
    assert meanings(propose(frame, [], ["x"]), ask) == {
        "stimulus": "a",
        "yes_count": "r",
        "n": "of",
        "alternatives": 2,
    }


def test_codes_must_leave_one_for_no():
    ask, _ = replies("", "2", "outcome", "hit miss late", "")
    with pytest.raises(UserError, match="no code is left for no or wrong"):
        meanings(propose(CODED, [], ["x"]), ask)


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
def test_a_command_in_a_terminal_asks_and_saves_the_options(tmp_path):
    CODED.drop(columns="other").to_csv(tmp_path / "data.csv", index=False)
    near, far = os.openpty()
    os.write(near, b"hit\nlate\n\nmm\n\n")  # codes, no forced choice, unit, save
    done = subprocess.run(
        [sys.executable, "-m", "slipscale", "analyse", "data.csv", "--out", "results"],
        cwd=tmp_path,
        stdin=far,
        stdout=far,
        stderr=subprocess.PIPE,
        timeout=120,
        check=False,
        env=os.environ | {"MPLBACKEND": "agg"},
    )
    os.close(far)
    os.close(near)
    assert done.returncode == 0, done.stderr
    assert 'missing = ["late"]' in (tmp_path / "analysis.toml").read_text()
    assert (tmp_path / "results" / "report.html").is_file()


def test_without_a_terminal_nothing_is_asked(tmp_path, monkeypatch, capsys):
    CODED.to_csv(tmp_path / "data.csv", index=False)
    monkeypatch.setattr("builtins.input", lambda _: pytest.fail("asked without a terminal"))
    assert commands.main(["analyse", str(tmp_path / "data.csv")]) == 2
    assert "expected options, for example" in capsys.readouterr().err
