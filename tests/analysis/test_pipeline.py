"""`slipscale analyse`, whole."""

import hashlib
import json
import re

import pandas as pd
import pytest

from slipscale import commands
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reporting.files import write_analysis
from slipscale.analysis.reporting.terminal import print_table3
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.faults import UserError


def digests(folder):
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.iterdir()}


def test_analyse_writes_what_the_contract_says_where_it_says(dataset, capsys):
    folder = dataset()
    assert commands.main(["analyse", str(folder)]) == 0
    out = folder / "derivatives" / "slipscale"
    header = "amplitude_um_pp,n,mean,maximum_deviation,standard_deviation"
    lines = (out / "table3.csv").read_text().splitlines()
    assert lines[0] == header
    assert len(lines) == 5
    estimates = pd.read_csv(out / "estimates.csv")
    assert len(estimates) == 48
    assert {"participant_id", "amplitude_um_pp", "estimate", "normalised"} <= set(estimates)
    assert {"fig15.svg", "fig15.png", "report.html"} <= set(digests(out))
    assert {path.name for path in [*out.glob("*.png"), *out.glob("*.pdf")]} == {"fig15.png"}
    assert "Table III" in capsys.readouterr().out
    # A second run gives the same bytes, file by file.
    first = digests(out)
    assert digests(write_analysis(analyse(folder), out).parent) == first
    # Other formats of figures are drawn on request; later analyses leave no outdated pictures.
    assert commands.main(["analyse", str(folder), "--figures", "png", "pdf"]) == 0
    pictures = {path.name for path in [*out.glob("*.png"), *out.glob("*.pdf")]}
    assert pictures == {
        f"{path.stem}.{each}" for path in out.glob("*.svg") for each in ("png", "pdf")
    }
    assert commands.main(["analyse", str(folder)]) == 0
    assert digests(out) == first
    page = (out / "report.html").read_text().replace("http://www.w3.org", "")
    assert "http" not in page
    assert page.count("<svg") == 4
    identifiers = re.findall(r' id="([^"]+)"', page)
    assert len(identifiers) == len(set(identifiers))
    found = json.loads((out / "inference.json").read_text())
    assert set(found["rm_anova"]) >= {
        "scale",
        "F",
        "df1",
        "df2",
        "p",
        "epsilon_gg",
        "p_gg",
        "epsilon_hf",
        "eta2_generalised",
    }
    assert found["rm_anova"]["scale"] == "log"
    assert set(found["friedman"]) >= {"chi2", "df", "p"}
    assert set(found["power_law"]) >= {"exponent", "ci95", "n"}
    assert found["normalisation"]["rule"] == "scale_top"
    assert "reason" in found["difference"]
    assert len(found["pairwise"]) == 6
    wide = pd.read_csv(out / "wide.csv")
    assert list(wide.columns[:5]) == [
        "participant_id",
        "estimate_0",
        "estimate_0_5",
        "estimate_1_2",
        "estimate_2_3",
    ]
    assert r"\toprule" in (out / "table3.tex").read_text()


@pytest.mark.parametrize("mode,banner", [("pilot", True), ("participant", False)])
def test_only_a_pilot_s_report_bears_a_banner(dataset, page, mode, banner):
    text = page(analyse(dataset(mode=mode)))
    assert ("PILOT DATA" in text) is banner


def test_the_user_s_rule_wins_over_the_study_s_and_both_are_said(dataset):
    folder = dataset(choices='normalisation = "top_stimulus"')
    analysis = analyse(folder, normalise="scale_top")
    assert analysis.rule == "scale_top"
    assert any("top_stimulus" in sentence for sentence in analysis.problems)


def test_what_the_user_typed_cannot_become_markup(dataset, page):
    rows = dataset.default_estimates(1)
    rows[0] |= {"estimate": "<script>alert(1)</script>"}
    text = page(analyse(dataset(rows={"01": rows})))
    assert "<script>" not in text
    assert "&lt;script&gt;" in text


@pytest.mark.parametrize(
    "text, sentence",
    [
        ("a,0,1\na,0.5,2\na,1.2,5\n", "There is only one participant"),
        ("a,1.2,1\nb,1.2,2\nc,1.2,4\n", "There is only one amplitude"),
        ("a,0,0\na,1,0\nb,0,0\nb,1,0\n", "All estimates are zero"),
        (
            "a,0,1\na,1,5\nb,0,2\nb,1,3\nc,1,4\n",
            "1 of 3 participants have no estimate for at least one amplitude",
        ),
    ],
)
def test_poor_data_gets_a_sentence_and_what_can_be_computed(table_by_hand, page, text, sentence):
    path = table_by_hand("participant_id,amplitude_um_pp,estimate\n" + text)
    analysis = analyse(path, normalise="none")
    assert any(sentence in problem for problem in analysis.problems), analysis.problems
    assert analysis.table3["mean"].notna().all()
    assert sentence in page(analysis)


def test_what_one_participant_does_not_have_is_said_on_the_terminal(table_by_hand, capsys):
    path = table_by_hand("participant_id,amplitude_um_pp,estimate\na,0,1\na,0.5,2\n")
    print_table3(analyse(path))
    said = capsys.readouterr().out
    assert "nan" not in said
    assert said.count("n/a") == 4  # maximum deviation and SD at two levels


def test_all_zeros_under_the_default_rule_still_give_a_table(table_by_hand):
    path = table_by_hand("participant_id,amplitude_um_pp,estimate\na,0,0\na,1,0\nb,0,0\nb,1,0\n")
    analysis = analyse(path)
    assert analysis.rule == "none"
    assert list(analysis.table3["mean"]) == [0, 0]


def test_nothing_answered_is_refused(table_by_hand):
    path = table_by_hand("participant_id,amplitude_um_pp,estimate\na,0,n/a\n")
    with pytest.raises(UserError, match="no answered trials"):
        analyse(path)


def test_a_data_set_of_descending_differences_alone_is_analysed(dataset, page):
    row = dataset.difference_row
    people = {f"{n:02d}": [row(1, 2.3, 1.2, "yes"), row(2, 1.2, 1.2, "no")] for n in range(1, 7)}
    folder = dataset(differences=people)
    for path in folder.glob("sub-*/beh/*magnitude*"):
        path.unlink()
    analysis = analyse(folder)
    assert analysis.inference.difference.steps[0].yes == 6
    assert analysis.inference.rm_anova == NotComputed("no magnitude estimates")
    assert "felt a difference" in page(analysis)


def test_tests_that_the_study_did_not_choose_are_not_run(dataset):
    analysis = analyse(dataset(choices='tests = ["friedman"]'))
    assert analysis.inference.friedman.n == 6
    assert analysis.inference.rm_anova == NotComputed("not chosen in the study file")
