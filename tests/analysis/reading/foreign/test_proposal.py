"""Without options, a command describes the columns and proposes the options."""

import shlex
from pathlib import Path

import pandas as pd
import pytest

from slipscale import commands
from slipscale.analysis.reading.foreign.presets import PRESETS, preset_of
from slipscale.analysis.reading.foreign.proposal import proposal_for, propose

pytestmark = pytest.mark.usefixtures("without_models")

TRIALS = pd.DataFrame(
    {
        "who": list("aabb") * 6,
        "size": [1, 2, 4, 8] * 6,
        "felt": ["no", "yes", "yes", "yes", "no", "no"] * 4,
        "rt": [0.1 * place for place in range(24)],
    }
)


DATA = [Path("data.csv")]
EVENTS = pd.DataFrame(
    {
        "onset": [1.0, 2.0, 3.0, 4.0],
        "duration": 1,
        "trial_type": ["heat", "rate"] * 2,
        "temperature": [44, None, 45, None],
        "rating": [None, 9.1, None, 19.3],
    }
)
CHOICES = pd.DataFrame(
    {"judge": list("aab"), "one": list("xyz"), "two": list("yzx"), "best": list("xzx")}
)


@pytest.mark.parametrize(
    "frame, expected",
    [
        (TRIALS, "--participant who --stimulus size --answer felt"),
        (
            pd.DataFrame(
                [
                    {"who": who, "off": off, "said": int(off > 0), "cond": cond, "side": cond}
                    for who in "ab"
                    for cond, least in (("still", -2), ("moving", -1))
                    for off in range(least, least + 5)
                ]
            ),
            "--participant who --stimulus off --answer said --factor cond",
        ),
        (
            pd.DataFrame({"subj": ["a", "b"] * 3, "x": [1, 1, 2, 2, 3, 3], "k": 4, "n": 9}),
            "--participant subj --stimulus x --yes-count k --n n",
        ),
        (
            pd.DataFrame({"1": [1, 2, 3], "2": [2, 4, 9], "3": 10}),
            "--no-header --stimulus 1 --yes-count 2 --n 3",
        ),
        (
            pd.DataFrame({"resp": [0, 1], "S1": 1, "S2": 2, "S3": 3}),
            "--triad S1,S2,S3 --answer resp",
        ),
        (pd.DataFrame({"": ["p", "q"], "p": [0, 3], "q": [5, 0]}), "--matrix wins"),
        (pd.DataFrame({"": ["p", "q"], "p": [1, 0.3], "q": [0.3, 1]}), "--matrix similarities"),
        (
            pd.DataFrame(
                {"psychopyVersion": 1, "level": [1, 2, 3], "trials.thisN": [0, 1, 2], "k.corr": 1}
            ),
            "--stimulus level --answer k.corr",
        ),
        (EVENTS, "--stimulus temperature --response rating --rows-of trial_type=heat,rate"),
        (CHOICES, "--participant judge --first one --second two --chosen best"),
        (
            CHOICES.assign(best=["left", "right", "left"]),
            "--participant judge --first one --second two --chosen best",
        ),
        (
            pd.DataFrame({"who": list("abc"), "L2": [3, 5, 4], "L4": [6, 7, 9], "L8": 9, "n": 9}),
            "--participant who --levels L2 L4 L8 --n n",
        ),
        (
            pd.DataFrame({"mm": [1, 2, 4], "s1": [3, 5, 8], "s2": [2, 6, 9]}),
            "--people-in-columns --stimulus mm",
        ),
        (
            pd.DataFrame({"x": [1, 2, 4], "percent": [30, 50, 80], "n_trials": 20}),
            "--stimulus x --percent percent --n n_trials",
        ),
        (
            pd.DataFrame({"x": [1, 2, 4], "n_correct": [3, 5, 8], "n_wrong": [7, 5, 2]}),
            "--stimulus x --yes-count n_correct --no-count n_wrong",
        ),
        (
            pd.DataFrame({"x": [1, 2, 4], "outcome": ["hit", "late", "miss"]}),
            "--stimulus x --answer outcome --yes CODE",
        ),
        (  # PsychoPy's rows of other routines have no level.
            pd.DataFrame({"size": ["1", None, "2", "4"], "felt": ["1", None, "0", "1"]}),
            "--stimulus size --answer felt",
        ),
        (
            pd.DataFrame(
                {
                    "subject_nr": 3,
                    "count_trial": 1,
                    "experiment_file": "x",
                    "level": [1, 2, 3],
                    "correct": [1, 0, 1],
                }
            ),
            "--participant subject_nr --stimulus level --answer correct",
        ),
    ],
)
def test_what_a_table_reveals_is_proposed(frame, expected):
    assert propose(frame, DATA, DATA).command == f"slipscale analyse data.csv {expected} --map"


def test_what_a_table_does_not_reveal_is_asked_for_with_the_candidates():
    found = propose(TRIALS.assign(other=[1, 2, 3] * 8), DATA, DATA)
    assert [*map(str, found.questions)] == [
        "Which column contains the levels (--stimulus)? size (1, 2, 4, 8), other (1, 2, 3).",
    ]
    found = propose(TRIALS[["size"]], DATA, DATA * 2)
    assert "--participant-from-name" in found.command
    assert str(found.questions[0]).startswith("Which column contains the answers")


def of_people(rows, **columns):
    """Return a table of two people with these columns, and answers."""
    frame = pd.DataFrame({"who": ["a"] * rows + ["b"] * rows, "resp": ["no", "yes"] * rows})
    return frame.assign(**columns)


@pytest.mark.parametrize(
    "frame, stimulus",
    [
        # Levels of a track, next to the number of a phase.
        (
            of_people(40, phase=[n // 2 for n in range(80)], level=[n / 7 for n in range(80)]),
            "level",
        ),
        (of_people(20, phase=[*range(1, 21)] * 2, size=[1, 2, 3, 4, 5] * 8), "size"),
        (of_people(20, phase=[*range(1, 21)] * 2), "LEVEL"),
        # A score of a questionnaire does not vary within people.
        (of_people(4, anger=[20] * 4 + [11] * 4), "LEVEL"),
        (of_people(4, anger=[20] * 4 + [11] * 4, third=[31] * 8), "LEVEL"),
        (of_people(6, level=[1, 1, 2, 2, 3, 3] * 2), "level"),
    ],
)
def test_numbers_of_trials_and_scores_of_people_are_no_levels(frame, stimulus):
    assert propose(frame, DATA, DATA).given["stimulus"] == stimulus


def test_a_table_with_only_numbers_of_trials_asks_for_the_levels():
    frame = of_people(20, phase=[*range(1, 21)] * 2)
    question = str(propose(frame, DATA, DATA).questions[0])
    assert question.startswith("Which column contains the levels (--stimulus)? phase (1, 2, 3")


def test_every_preset_can_be_reached():
    """A preset after one with fewer marks would never apply."""
    for preset in PRESETS[3:-1]:
        names = [mark.strip("(").partition("|")[0].replace(".*", "x") for mark in preset.marks]
        assert preset_of(names) is preset


def test_the_proposed_command_works(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    TRIALS.to_csv("data.csv", index=False)
    assert commands.main(["analyse", "data.csv"]) == 2
    said, refusal = capsys.readouterr()
    assert "size: 1 to 8, 4 values (1, 2, 4, 8)" in said
    assert "felt: text, 2 values (" in said
    command = refusal.partition("for example: ")[2]
    assert commands.main([*shlex.split(command)[1:], "--out", "results"]) == 0
    assert commands.main(["analyse", "data.csv", "--out", "results"]) == 0


@pytest.mark.parametrize(
    "lines, command",
    [
        ("red 1 0 421 1\nred 2 1 399 1\nblue 4 1 350 1\nred 1 0 366 1", "--no-header"),
        ("a,1,10,20\na,2,14,20\nb,1,15,20\nb,2,17,20", "--no-header"),
        ("who,1,2,4\na,11,19,30\nb,8,17,40", "slipscale analyse"),
    ],
    ids=["PsyToolkit", "words and counts", "levels as names"],
)
def test_a_first_line_like_the_others_is_no_header(tmp_path, lines, command):
    (tmp_path / "x.txt").write_text(lines + "\n")
    found = proposal_for([tmp_path / "x.txt"]).command
    assert command in found
    assert ("--no-header" in found) == (command == "--no-header")


def test_a_folder_of_tables_is_described_by_its_first_one(tmp_path):
    for who in "ab":
        TRIALS.drop(columns="who").to_csv(tmp_path / f"{who}.csv", index=False)
    found = proposal_for([tmp_path])
    assert str(found).startswith("a.csv, the first of 2 tables: 24 rows\n  size: 1 to 8")
    assert "--participant-from-name --stimulus size --answer felt" in str(found.refusal)
