"""The rule by which `make benchmarks` compares ratios, and what is recorded."""

import json
import time

import pytest

from benchmarks import quick, ways

RECORDED = {"processor": 2.0, "elapsed": 2.0}


def busy() -> None:
    end = time.process_time() + 0.02
    while time.process_time() < end:
        pass


@pytest.mark.parametrize(
    "found, expected",
    [
        ({"processor": 2.4, "elapsed": 4.0}, []),
        ({"processor": 2.41, "elapsed": 0.1}, ["processor"]),
        ({"processor": 0.1, "elapsed": 4.01}, ["elapsed"]),
    ],
)
def test_a_ratio_may_grow_by_20_percent_and_waiting_may_double(found, expected):
    assert quick.worse(found, RECORDED) == expected
    assert quick.worse(found, {}) == []


def test_the_first_round_does_not_count_and_an_outlier_moves_nothing(monkeypatch):
    times = iter([50, 1, 2, 1, 2, 1, 90, 1])
    monkeypatch.setattr(quick, "spent_s", lambda _: dict.fromkeys(quick.WORSE, next(times)))
    assert quick.ratios((None, None), rounds=3) == RECORDED


def test_waiting_is_elapsed_time_only():
    spent = quick.spent_s(lambda: (busy(), time.sleep(0.2)))
    assert spent["elapsed"] >= 0.2
    assert 0.02 <= spent["processor"] < spent["elapsed"]


@pytest.fixture
def status(tmp_path, monkeypatch):
    """Return a function that runs the command with given ratios and returns its exit status."""

    def run(*measured: float) -> int:
        figures, growth = tmp_path / "figures.json", iter(measured)
        record = {"date": "2026-11-22", "machine": "x", "ratios": {"one": RECORDED}}
        figures.write_text(json.dumps(record))
        monkeypatch.setattr(quick, "FIGURES", figures)
        monkeypatch.setattr(quick, "guarded", lambda _: {"one": (None, None)})
        monkeypatch.setattr(
            quick, "ratios", lambda *_: {"processor": 2.0 * next(growth), "elapsed": 2.0}
        )
        monkeypatch.setattr("sys.argv", ["quick"])
        return quick.main()

    return run


def test_only_a_ratio_that_grew_twice_in_a_row_is_a_failure(status, capsys):
    assert status(1.1) == 0
    assert status(1.5, 1.1) == 0
    assert "slower" not in capsys.readouterr().out
    assert status(1.5, 1.3) == 1
    assert "slower than recorded, twice: one (processor time)" in capsys.readouterr().out


def test_every_recorded_ratio_is_of_a_benchmark_that_exists(tmp_path, monkeypatch):
    monkeypatch.setattr(ways, "PARTICIPANTS", 2)
    monkeypatch.setattr(ways, "ROWS", 8)
    recorded = json.loads(quick.FIGURES.read_text(encoding="utf-8"))
    assert ways.guarded(tmp_path).keys() <= recorded["ratios"].keys()
    assert all(each.keys() == quick.WORSE.keys() for each in recorded["ratios"].values())
    assert recorded["date"]
    assert recorded["machine"]
