"""The command: exit status, JSON, samples."""

from __future__ import annotations

import csv
import json

import pytest
from scipy.stats import ttest_rel

from slipscale import commands


def test_json_gives_counts_as_strings(capsys):
    assert commands.main(["reconstruct", "biet2007_table3", "--json"]) == 0
    first = json.loads(capsys.readouterr().out)["columns"][0]
    assert first["label"] == "0 um"
    assert first["consistent"] is True
    assert first["multisets"] == "40711"


def test_samples_are_csv_and_repeat_with_their_seed(capsys, tmp_path):
    words = ["reconstruct", "biet2007_table3", "--sample", "3", "--seed", "5"]
    assert commands.main(words) == 0
    shown = capsys.readouterr().out
    assert commands.main([*words, "--out", str(tmp_path / "s.csv")]) == 0
    assert (tmp_path / "s.csv").read_text() == shown
    rows = list(csv.DictReader(shown.splitlines()))
    assert len(rows) == 12
    assert sum(int(rows[0][f"rating_{i}"]) for i in range(1, 13)) == 153


def test_long_samples_are_the_same_ratings_one_a_row(capsys):
    words = ["reconstruct", "biet2007_table3", "--sample", "2", "--seed", "5"]
    commands.main(words)
    wide = list(csv.DictReader(capsys.readouterr().out.splitlines()))
    commands.main([*words, "--long"])
    long = list(csv.DictReader(capsys.readouterr().out.splitlines()))
    assert len(long) == 4 * 2 * 12
    assert [
        (row["column"], row["sample"], str(i), row[f"rating_{i}"])
        for row in wide
        for i in range(1, 13)
    ] == [tuple(row.values()) for row in long]
    assert list(long[0]) == ["column", "sample", "place", "rating"]


def test_an_inconsistent_table_exits_1_and_says_why(capsys, tmp_path):
    (tmp_path / "t.csv").write_text("label,n,mean,sd,scale_maximum\na,28,5.19,1.00,10\n")
    assert commands.main(["reconstruct", str(tmp_path / "t.csv")]) == 1
    assert "GRIM" in capsys.readouterr().out


PAIRED = ["--conclusions", "--design", "paired"]
MIXED = """label,n,mean,sd,scale_minimum,scale_maximum
a,20,3.20,1.20,1,7
impossible,20,3.20,9.00,1,7
large,500,4.00,1.50,1,7
b,25,4.40,1.29,1,7
"""


@pytest.mark.parametrize(
    "words", [[], ["--sample", "2"], ["--conclusions", "--design", "independent"]]
)
def test_one_impossible_column_silences_no_other(capsys, tmp_path, words):
    (tmp_path / "t.csv").write_text(MIXED.replace("large,500,4.00,1.50,1,7\n", ""))
    assert commands.main(["reconstruct", str(tmp_path / "t.csv"), *words]) == 1
    said = "".join(capsys.readouterr())
    assert "sd 9.00 is impossible on a scale from 1 to 7" in said
    assert "Welch's t of b minus a: 3.227" in said or "--design" not in words
    if "--sample" in words:
        assert [line.split(",")[:2] for line in said.splitlines() if line[:2] in ("a,", "b,")] == [
            ["a", "1"], ["a", "2"], ["b", "1"], ["b", "2"],
        ]  # fmt: skip


def test_a_column_too_large_to_count_has_a_verdict_if_a_data_set_is_found(capsys, tmp_path):
    (tmp_path / "t.csv").write_text(MIXED)
    words = ["reconstruct", str(tmp_path / "t.csv"), "--minutes", "0"]
    assert commands.main([*words, "--sample", "1"]) == 1  # A column is impossible.
    assert "column 'large': no samples: counting needs about" in capsys.readouterr().err
    (tmp_path / "t.csv").write_text(MIXED.replace("9.00", "1.20"))
    assert commands.main([*words, "--sample", "1"]) == 2
    assert "column 'large' not counted: counting needs about" in capsys.readouterr().err
    assert commands.main(words) == 0
    said = capsys.readouterr()
    assert "multisets        40" in said.out
    assert "(saddle-point estimate)" in said.out
    assert "one verified data set" in said.out
    assert "counting needs about" in said.out
    assert commands.main([*words, "--json"]) == 0
    large = json.loads(capsys.readouterr().out)["columns"][2]
    assert large["consistent"] is True
    assert large["multisets"] is None
    assert len(large["witness"]) == 500


def test_conclusions_ask_whose_ratings_the_columns_are(capsys, tmp_path):
    (tmp_path / "t.csv").write_text(TWO)
    assert commands.main(["reconstruct", str(tmp_path / "t.csv"), "--conclusions"]) == 2
    assert 'design = "paired" (the same participants' in capsys.readouterr().err


TWO = "label,n,mean,sd,scale_maximum,amplitude_um_pp\na,5,2.40,1.14,9,0.5\nb,5,6.40,1.14,9,1.2\n"


def test_conclusions_are_said_and_written_as_strict_json(capsys, tmp_path):
    (tmp_path / "t.csv").write_text(TWO)
    words = ["reconstruct", str(tmp_path / "t.csv"), *PAIRED]
    assert commands.main(words) == 0
    said = capsys.readouterr().out
    assert "paired t(4) of b minus a" in said
    assert "least favourable" in said
    assert commands.main([*words, "--json"]) == 0

    def refuse(word):
        raise AssertionError(word)

    found = json.loads(capsys.readouterr().out, parse_constant=refuse)["conclusions"]
    assert {row["name"] for row in found["distributions"]} == {
        "rm_f", "friedman", "t.a.b", "exponent.mean", "exponent.sd",
    }  # fmt: skip
    assert found["distributions"][0]["samples"] == 1000


def test_columns_too_large_to_count_are_bounded_all_the_same(capsys, tmp_path):
    (tmp_path / "t.csv").write_text(
        "label,n,mean,sd,scale_maximum\na,300,40.00,12.00,100\nb,300,60.00,12.00,100\n"
    )
    assert commands.main(["reconstruct", str(tmp_path / "t.csv"), *PAIRED]) == 0
    assert "paired t(299) of b minus a: 14.4" in capsys.readouterr().out


def test_bounds_come_with_the_tables_that_attain_them(capsys, tmp_path):
    (tmp_path / "t.csv").write_text(TWO.replace("6.40,1.14", "6.40,1.52"))
    words = ["reconstruct", str(tmp_path / "t.csv"), *PAIRED]
    assert commands.main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["conclusions"]
    (t,) = (row for row in found["always"] + found["depends"] if row["name"] == "t.a.b")
    for value, table in ((t["low"], t["at_low"]), (t["high"], t["at_high"])):
        assert ttest_rel(*reversed(table)).statistic == pytest.approx(value)
    commands.main(words)
    first = " ".join(f"{v:g}" for v in t["at_low"][0])
    assert f"{t['low']:.4g} with a: {first}; b: " in capsys.readouterr().out


def test_too_many_data_sets_to_list_are_bounded_by_sums_and_sums_of_squares(capsys, tmp_path):
    (tmp_path / "t.csv").write_text(
        "label,n,mean,sd,scale_maximum\na,14,40.00,12.00,100\nb,14,60.00,12.00,100\n"
    )
    assert commands.main(["reconstruct", str(tmp_path / "t.csv"), *PAIRED]) == 0
    said = capsys.readouterr().out
    assert "these bounds use only sums and sums of squares" in said
    # By hand: 20 over 24/√14, SDs of 12 in opposite order; and its square.
    assert "paired t(13) of b minus a: 3.118 to infinite" in said
    assert "(bounds, perhaps not attained)" in said
    assert "repeated-measures F(1, 13): 9.722 to infinite" in said


@pytest.mark.parametrize(
    "words, said",
    [
        (["nowhere.toml"], "cannot be read"),
        (["biet2007_table3", "--sample", "0"], "expected 1 or more"),
        (["biet2007_table3", "--long"], "add --sample N"),
        (["biet2007_table3", "--sample", "1", "--conclusions"], "--conclusions writes a report"),
        (["biet2007_table3", "--sample", "1", "--json"], "--json writes the counts"),
        (["biet2007_table3", "--sample", "1", "--memory-gib", "0.0001"], "needs about"),
        (["biet2007_table3", "--sample", "1", "--minutes", "0"], "0 min are allowed"),
    ],
)
def test_a_users_mistake_exits_2_with_a_sentence(capsys, words, said):
    assert commands.main(["reconstruct", *words]) == 2
    assert said in capsys.readouterr().err


def test_what_takes_long_is_announced(capsys, tmp_path, monkeypatch):
    (tmp_path / "t.csv").write_text(TWO)
    monkeypatch.setattr("slipscale.analysis.cli.reconstruct.WORTH_SAYING_S", -1.0)
    assert commands.main(["reconstruct", str(tmp_path / "t.csv")]) == 0
    assert "column 'a': counting takes about 1 s and 0.0 GiB" in capsys.readouterr().err


def test_conclusions_that_take_long_are_announced(capsys, tmp_path, monkeypatch):
    (tmp_path / "t.csv").write_text(TWO)
    words = ["reconstruct", str(tmp_path / "t.csv"), *PAIRED]
    assert commands.main(words) == 0
    assert capsys.readouterr().err.strip() == ""
    monkeypatch.setattr("slipscale.analysis.cli.reconstruct.WORTH_SAYING_S", 1.0)
    assert commands.main(words) == 0
    assert "conclusions across columns take about 4 s" in capsys.readouterr().err


TESTED = """
title = "Two columns, and a test between them"
[scale]
maximum = 9
[[column]]
label = "a"
n = 5
mean = "2.40"
sd = "1.14"
[[column]]
label = "b"
n = 5
mean = "6.40"
sd = "1.52"
[[test]]
kind = "paired_t"
statistic = "4.78"
"""


@pytest.mark.parametrize("t, verdict, status", [("4.78", "possible", 0), ("99", "impossible", 1)])
def test_a_printed_test_is_answered_in_words_json_and_page(capsys, tmp_path, t, verdict, status):
    (tmp_path / "t.toml").write_text(TESTED.replace("4.78", t))
    words = ["reconstruct", str(tmp_path / "t.toml"), "--html", str(tmp_path / "page.html")]
    assert commands.main(words) == status
    assert f"paired t of a, b: t = {t}: {verdict}" in capsys.readouterr().out
    page = (tmp_path / "page.html").read_text()
    assert f">{verdict}<" in page
    assert commands.main([*words, "--json"]) == status
    (found,) = json.loads(capsys.readouterr().out)["tests"]
    assert found["verdict"] == verdict
    if found["example"]:
        assert round(ttest_rel(*reversed(found["example"])).statistic, 2) == float(t)
    assert bool(found["example"]) == (verdict == "possible")
