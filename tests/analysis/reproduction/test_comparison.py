"""The comparison with the paper: names, records, exits."""

import json
from collections import Counter

import pytest

from slipscale import commands
from slipscale.analysis.published.biet2007 import TABLE3
from slipscale.analysis.reproduction import comparison, table3
from slipscale.analysis.reproduction.comparison import Comparison, Outcome, choose, compare
from slipscale.analysis.reproduction.equation import Check, apart, items
from slipscale.analysis.reproduction.terminal import print_comparisons
from slipscale.faults import UserError


def run(*words):
    return commands.main(["reproduce", *words])


def test_every_cell_of_table_iii_and_point_of_fig_15_agrees(tmp_path, capsys):
    assert run("--json", "--out", str(tmp_path / "results"), "table3", "fig15") == 0
    records = json.loads(capsys.readouterr().out)
    assert len(records) == 16
    for record in records:
        assert record["agrees"] is True
        assert record["drifted"] is False
        assert "never published" in record["reason"]
    assert records[0]["item"] == "table3.0.mean"
    assert records[0]["published"] == float(TABLE3[0].mean)
    assert sorted(p.name for p in (tmp_path / "results").iterdir()) == ["fig15.png", "fig15.svg"]


def test_an_exact_item_comes_alone_and_a_beginning_brings_its_kin():
    assert choose(["fig15.0"]) == ["fig15.0"]
    assert choose(["fig15"]) == ["fig15.0", "fig15.0.5", "fig15.1.2", "fig15.2.3"]
    with pytest.raises(UserError, match="unknown item 'fig99'"):
        choose(["fig99"])


def test_drift_exits_1(tmp_path, capsys, monkeypatch):
    moved = comparison.recorded_values() | {"fig15.1.2": 56.0}
    monkeypatch.setattr(comparison, "recorded_values", lambda: moved)
    assert run("--out", str(tmp_path), "fig15") == 1
    assert "the recorded value is 56.0" in " ".join(capsys.readouterr().out.split())


def compared(published, ours, *, must_agree=False, **others):
    outcome = Outcome(
        published=published, ours=ours, unit="mm", reason="", must_agree=must_agree, **others
    )
    return Comparison(item="x", outcome=outcome, recorded=ours)


def test_a_disagreement_fails_only_where_it_must_agree():
    assert compared("14.75", 13.6).outcome.agrees is False
    assert not compared("14.75", 13.6).failed
    assert compared("14.75", 13.6, must_agree=True).failed


def test_an_item_without_a_printed_number_is_neither_right_nor_wrong():
    assert compared(None, 30.0).record()["agrees"] is None


def test_words_instead_of_numbers_are_compared_by_a_rule():
    found = compared("above 10", 11.7, rule=lambda _, ours: ours > 10)
    assert found.record()["agrees"] is True
    assert found.record()["published"] == "above 10"


def test_a_value_nobody_recorded_counts_as_drift():
    outcome = Outcome(published=None, ours=1.0, unit="", reason="")
    assert Comparison(item="x", outcome=outcome, recorded=None).failed


def test_the_items_cover_every_equation_table_and_figure_of_the_paper():
    found = Counter(part for one in compare() for part in one.outcome.covers)
    wanted = [f"eq.{n}" for n in range(1, 48)]
    wanted += [f"table.{n}" for n in (1, 2, 3)] + [f"fig.{n}" for n in range(1, 16)]
    assert set(found) == set(wanted)


def test_the_summary_counts_agreement_by_construction_separately(capsys):
    assert compared("0", 0.0).outcome.group == "agrees"
    assert compared("0", 1.0, by_construction=True).outcome.group == "differs"
    assert compared(None, 1.0).outcome.group == "not published"
    print_comparisons(compare(["table3", "table1", "eq.1", "eq.4", "eq.5", "fig6.neutral_line"]))
    said = " ".join(capsys.readouterr().out.split())
    assert "Independent items: 1 agree with the paper, and 1 differ" in said
    assert "By construction, 23 items agree" in said
    assert "For 1 items, the paper gives no number" in said


def test_an_equation_with_a_wrong_sign_differs():
    right = Check(difference=lambda: apart([1.0, -2.0], [1.0, -2.0 + 1e-9]), reason="")
    wrong = Check(difference=lambda: apart([1.0, -2.0], [1.0, 2.0]), reason="", also=(3,))
    ours = items({1: right, 2: wrong})
    assert (ours["eq.1"]().ours, ours["eq.1"]().agrees) == (0, True)
    assert (ours["eq.2"]().ours, ours["eq.2"]().agrees) == (2, False)
    assert ours["eq.2"]().covers == ("eq.2", "eq.3")


def test_every_source_has_a_recorded_value_for_each_item_and_none_left_over():
    assert set(comparison.recorded_values()) == set(comparison.item_names())


def test_compare_tells_its_progress():
    told = []
    compare(["fig15.0.5"], told.append)
    assert told == ["fig15.0.5"]


def test_an_item_that_does_not_exist_is_answered_with_those_that_do(tmp_path, capsys):
    assert run("--out", str(tmp_path / "out"), "fig99") == 2
    said = capsys.readouterr().err
    assert "expected one of table3, fig15," in said
    assert len(said) < 400
    assert not (tmp_path / "out").exists()


def test_an_out_that_cannot_be_made_is_refused_before_anything_is_computed(
    tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr(comparison, "compare", lambda *_: pytest.fail("computed"))
    (tmp_path / "taken").write_text("")
    assert run("--out", str(tmp_path / "taken")) == 2
    assert "taken: is a file; expected a folder" in capsys.readouterr().err


def test_fig15_puts_arithmetic_means_beside_the_papers_points_on_linear_axes():
    (axes,) = table3.draw_fig15().axes
    ours, paper = axes.containers
    assert ours.get_label() == "arithmetic mean, 95 % CI"
    assert ours.lines[0].get_ydata() == pytest.approx([12.75, 19.5833, 56.25, 81.3333], abs=1e-4)
    assert list(paper.lines[0].get_ydata()) == [12.75, 19.58, 56.25, 81.33]
    (bars,) = paper.lines[2]
    spread = [bar[1, 1] - bar[0, 1] for bar in bars.get_segments()]
    assert spread == pytest.approx([2 * sd for sd in (12.75, 8.11, 8.82, 10.76)])
    assert (axes.get_xscale(), axes.get_yscale(), axes.get_ylim()) == ("linear", "linear", (0, 100))
