"""`slipscale analyse`, whole."""

import hashlib

import pandas as pd
import pytest

import slipscale
from analysis.pipeline import analyse
from faults import UserError


def digests(folder):
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.iterdir()}


def test_analyse_writes_what_the_contract_says_where_it_says(dataset, capsys):
    folder = dataset()
    assert slipscale.main(["analyse", str(folder)]) == 0
    out = folder / "derivatives" / "slipscale"
    header = "amplitude_um_pp,n,mean,maximum_deviation,standard_deviation"
    lines = (out / "table3.csv").read_text().splitlines()
    assert lines[0] == header
    assert len(lines) == 5
    estimates = pd.read_csv(out / "estimates.csv")
    assert len(estimates) == 48
    assert {"participant_id", "amplitude_um_pp", "estimate", "normalised"} <= set(estimates)
    assert {"fig15.svg", "fig15.png", "report.html"} <= set(digests(out))
    assert "Table III" in capsys.readouterr().out


def test_a_second_run_gives_the_same_bytes(dataset):
    folder = dataset()
    first = digests(analyse(folder).out)
    assert digests(analyse(folder).out) == first
    assert "http" not in (folder / "derivatives/slipscale/report.html").read_text().replace(
        "http://www.w3.org", ""
    )


def test_a_pilot_s_report_bears_a_banner(dataset):
    assert "PILOT DATA" in analyse(dataset(mode="pilot")).report.read_text()


def test_a_participant_s_report_bears_none(dataset):
    assert "PILOT DATA" not in analyse(dataset()).report.read_text()


def test_the_user_s_rule_wins_over_the_study_s_and_both_are_said(dataset):
    analysis = analyse(dataset(choices='normalisation = "top_stimulus"'), normalise="scale_top")
    assert analysis.rule == "scale_top"
    assert any("top_stimulus" in sentence for sentence in analysis.problems)


def test_what_the_user_typed_cannot_become_markup(dataset):
    rows = dataset.default_estimates(1)
    rows[0] |= {"estimate": "<script>alert(1)</script>"}
    page = analyse(dataset(rows={"01": rows})).report.read_text()
    assert "<script>" not in page
    assert "&lt;script&gt;" in page


@pytest.mark.parametrize(
    "text, sentence",
    [
        ("a,0,1\na,0.5,2\na,1.2,5\n", "One participant"),
        ("a,1.2,1\nb,1.2,2\nc,1.2,4\n", "One amplitude"),
        ("a,0,0\na,1,0\nb,0,0\nb,1,0\n", "All estimates are zero"),
        ("a,0,1\na,1,5\nb,0,2\nb,1,3\nc,1,4\n", "1 of 3 participants lack an estimate"),
    ],
)
def test_poor_data_gets_a_sentence_and_what_can_be_computed(table_by_hand, text, sentence):
    path = table_by_hand("participant_id,amplitude_um_pp,estimate\n" + text)
    analysis = analyse(path, normalise="none")
    assert any(sentence in problem for problem in analysis.problems), analysis.problems
    assert analysis.table3["mean"].notna().all()
    assert sentence in analysis.report.read_text()


def test_all_zeros_under_the_default_rule_still_give_a_table(table_by_hand):
    path = table_by_hand("participant_id,amplitude_um_pp,estimate\na,0,0\na,1,0\nb,0,0\nb,1,0\n")
    analysis = analyse(path)
    assert analysis.rule == "none"
    assert list(analysis.table3["mean"]) == [0, 0]


def test_nothing_answered_is_refused(table_by_hand):
    path = table_by_hand("participant_id,amplitude_um_pp,estimate\na,0,n/a\n")
    with pytest.raises(UserError, match="no answered trials"):
        analyse(path)
