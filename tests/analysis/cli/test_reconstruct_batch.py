"""A verdict a row: any number of workers, resumable, whatever a row says."""

from __future__ import annotations

import csv

import pytest

from slipscale import commands
from slipscale.analysis.reconstruction.data_sets.batch import verdict

HEADER = "label,n,mean,sd,scale_minimum,scale_maximum,median,observed_maximum"
ROWS = {
    "fits,28,4.21,1.50,1,7,,": "consistent",
    "grim,28,5.19,1.50,1,7,,": "inconsistent GRIM",
    "grimmer,10,3.10,1.09,1,5,,": "inconsistent GRIMMER",
    "impossible,20,3.20,9.00,1,7,,": "inconsistent impossible",
    "extremes,5,2.40,1.14,1,7,,7": "inconsistent extremes",
    "median,5,2.40,1.14,1,7,2.3,": "inconsistent count",
    "long,500,4.00,1.50,1,7,,": "not counted",
    "word,many,4.00,1.50,1,7,,": "not understood",
    "cells,5": "not understood",
}


@pytest.fixture
def table(tmp_path):
    path = tmp_path / "many.csv"
    path.write_text("\n".join([HEADER, *ROWS, *list(ROWS)[:3] * 6]) + "\n")
    return path


def batch(table, out, *words):
    # What is in closed form takes no time, so that the long row alone is refused.
    given = [str(table), "--batch", "--out", str(out), "--minutes", "0", *words]
    return commands.main(["reconstruct", *given])


def test_every_row_has_a_verdict_and_all_are_summed_up(table, tmp_path, capsys):
    assert batch(table, tmp_path / "out.csv") == 1
    with (tmp_path / "out.csv").open() as file:
        found = list(csv.DictReader(file))
    assert [f"{row['verdict']} {row['failed']}".strip() for row in found[: len(ROWS)]] == list(
        ROWS.values()
    )
    assert [row["line"] for row in found[:3]] == ["2", "3", "4"]
    assert int(found[0]["multisets"]) > 0
    assert "needs about" in found[6]["reason"]
    assert float(found[6]["log10_estimate"]) > 8
    assert "got 'many'" in found[7]["reason"]
    said = capsys.readouterr().out
    assert "27 rows" in said
    assert "(GRIM 7, GRIMMER 7, count 1, extremes 1, impossible 1)" in said


def test_two_workers_give_what_one_gives(table, tmp_path):
    batch(table, tmp_path / "one.csv")
    batch(table, tmp_path / "two.csv", "--workers", "2")
    assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "two.csv").read_bytes()


@pytest.mark.parametrize("kept", [0, 40, 300, 700])
def test_what_was_interrupted_anywhere_goes_on(table, tmp_path, monkeypatch, kept):
    batch(table, tmp_path / "whole.csv")
    whole = (tmp_path / "whole.csv").read_bytes()
    head = whole.index(b"\n") + 1
    (tmp_path / "torn.csv").write_bytes(whole[: head + kept])
    judged = []
    judge = verdict
    monkeypatch.setattr(
        "slipscale.analysis.reconstruction.data_sets.batch.verdict",
        lambda row, **allowed: judged.append(row) or judge(row, **allowed),
    )
    batch(table, tmp_path / "torn.csv")
    assert (tmp_path / "torn.csv").read_bytes() == whole
    assert len(judged) == 27 - whole[head : head + kept].count(b"\n")


def test_verdicts_on_other_rows_are_not_gone_on_with(table, tmp_path, capsys):
    batch(table, tmp_path / "out.csv")
    before = (tmp_path / "out.csv").read_bytes()
    table.write_text(table.read_text().replace("4.21", "4.25"))
    assert batch(table, tmp_path / "out.csv") == 2
    assert "does not contain verdicts on these rows" in capsys.readouterr().err
    (tmp_path / "letter").write_text("Dear Sir")
    assert batch(table, tmp_path / "letter") == 2
    assert (tmp_path / "letter").read_text() == "Dear Sir"
    assert (tmp_path / "out.csv").read_bytes() == before


@pytest.mark.parametrize(
    "words, said",
    [
        (["--workers", "0"], "expected 1 or more"),
        (["--sample", "3"], "omit --sample"),
        (["--json", "--conclusions"], "omit --json, --conclusions"),
    ],
)
def test_what_does_not_go_with_a_batch_is_refused(table, tmp_path, capsys, words, said):
    assert batch(table, tmp_path / "out.csv", *words) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out.csv").exists()


def test_a_wrong_header_is_told_at_once(tmp_path, capsys):
    (tmp_path / "t.csv").write_text("n,mean,SD,scale_maximum\n5,2.40,1.14,7\n")
    assert batch(tmp_path / "t.csv", tmp_path / "out.csv") == 2
    assert "SD: expected one of" in capsys.readouterr().err
