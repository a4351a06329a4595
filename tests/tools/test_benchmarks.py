"""The rule by which `make benchmarks` compares ratios, and what is recorded."""

import json

import pytest

from benchmarks import quick


def test_only_a_ratio_more_than_30_percent_larger_is_a_regression():
    recorded = {"slower": 1.0, "as before": 1.0, "faster": 1.0}
    found = {"slower": 1.31, "as before": 1.3, "faster": 0.2}
    assert quick.worse(found, recorded) == ["slower"]


def test_a_benchmark_without_a_record_is_no_regression():
    assert quick.worse({"new": 99.0}, {}) == []


def test_the_first_round_does_not_count_and_an_outlier_moves_nothing(monkeypatch):
    times = iter([50, 1, 2, 1, 2, 1, 90, 1])
    monkeypatch.setattr(quick, "spent_s", lambda _: next(times))
    assert quick.ratio(None, None, rounds=3) == 2


@pytest.mark.parametrize("growth, status", [(1.2, 0), (1.4, 1)])
def test_the_exit_status_says_whether_a_ratio_grew(growth, status, tmp_path, monkeypatch, capsys):
    figures = tmp_path / "figures.json"
    figures.write_text(json.dumps({"date": "2026-11-22", "machine": "x", "ratios": {"one": 2.0}}))
    monkeypatch.setattr(quick, "FIGURES", figures)
    monkeypatch.setattr(quick, "ways", lambda _: {"one": (None, None)})
    monkeypatch.setattr(quick, "ratio", lambda *_: 2.0 * growth)
    monkeypatch.setattr("sys.argv", ["quick"])
    assert quick.main() == status
    assert ("more than 30 % larger than recorded: one" in capsys.readouterr().out) is bool(status)


def test_every_recorded_ratio_is_of_a_benchmark_that_exists(tmp_path, monkeypatch):
    monkeypatch.setattr(quick, "PARTICIPANTS", 2)
    monkeypatch.setattr(quick, "ROWS", 8)
    recorded = json.loads(quick.FIGURES.read_text(encoding="utf-8"))
    assert recorded["ratios"].keys() == quick.ways(tmp_path).keys()
    assert recorded["date"]
    assert recorded["machine"]
