"""The command: exit status, JSON, samples."""

from __future__ import annotations

import csv
import json

import pytest

import slipscale


def test_json_gives_counts_as_strings(capsys):
    assert slipscale.main(["reconstruct", "biet2007_table3", "--json"]) == 0
    first = json.loads(capsys.readouterr().out)["columns"][0]
    assert first["label"] == "0 um"
    assert first["consistent"] is True
    assert first["multisets"] == "40711"


def test_samples_are_csv_and_repeat_with_their_seed(capsys, tmp_path):
    words = ["reconstruct", "biet2007_table3", "--sample", "3", "--seed", "5"]
    assert slipscale.main(words) == 0
    shown = capsys.readouterr().out
    assert slipscale.main([*words, "--out", str(tmp_path / "s.csv")]) == 0
    assert (tmp_path / "s.csv").read_text() == shown
    rows = list(csv.DictReader(shown.splitlines()))
    assert len(rows) == 12
    assert sum(int(rows[0][f"rating_{i}"]) for i in range(1, 13)) == 153


def test_an_inconsistent_table_exits_1_and_says_why(capsys, tmp_path):
    (tmp_path / "t.csv").write_text("label,n,mean,sd,scale_maximum\na,28,5.19,1.00,10\n")
    assert slipscale.main(["reconstruct", str(tmp_path / "t.csv")]) == 1
    assert "GRIM" in capsys.readouterr().out


TWO = "label,n,mean,sd,scale_maximum,amplitude_um_pp\na,5,2.40,1.14,9,0.5\nb,5,6.40,1.14,9,1.2\n"


def test_conclusions_are_said_and_written_as_strict_json(capsys, tmp_path):
    (tmp_path / "t.csv").write_text(TWO)
    words = ["reconstruct", str(tmp_path / "t.csv"), "--conclusions"]
    assert slipscale.main(words) == 0
    said = capsys.readouterr().out
    assert "paired t(4) of b minus a" in said
    assert "least favourable" in said
    assert slipscale.main([*words, "--json"]) == 0

    def refuse(word):
        raise AssertionError(word)

    found = json.loads(capsys.readouterr().out, parse_constant=refuse)["conclusions"]
    assert {row["name"] for row in found["distributions"]} == {
        "rm_f", "friedman", "t.a.b", "exponent.mean", "exponent.sd",
    }  # fmt: skip
    assert found["distributions"][0]["samples"] == 1000


def test_too_many_data_sets_to_list_leave_distributions_without_bounds(capsys, tmp_path):
    (tmp_path / "t.csv").write_text(
        "label,n,mean,sd,scale_maximum\na,14,40.00,12.00,100\nb,14,60.00,12.00,100\n"
    )
    assert slipscale.main(["reconstruct", str(tmp_path / "t.csv"), "--conclusions"]) == 0
    said = capsys.readouterr().out
    assert "No bounds" in said
    assert "paired t(13)" in said


@pytest.mark.parametrize(
    "words, said",
    [
        (["nowhere.toml"], "cannot be read"),
        (["biet2007_table3", "--sample", "0"], "expected 1 or more"),
        (["biet2007_table3", "--sample", "1", "--conclusions"], "choose one"),
        (["biet2007_table3", "--memory-gib", "0.0001"], "needs about"),
    ],
)
def test_a_users_mistake_exits_2_with_a_sentence(capsys, words, said):
    assert slipscale.main(["reconstruct", *words]) == 2
    assert said in capsys.readouterr().err
