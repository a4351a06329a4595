"""What changed since the last run is said before the next one begins."""

from datetime import UTC, datetime

import pytest

from slipscale.commands import main
from slipscale.experiments.cli import sessions
from slipscale.experiments.dataset.backup import back_up, not_backed_up
from slipscale.experiments.dataset.journals import journals
from slipscale.experiments.running import changed_since
from slipscale.experiments.running.changed_since import changes
from slipscale.experiments.study.file import parse_study, study_text

TEXT = study_text("biet2007")
STUDY = parse_study(TEXT, "biet2007")


class Past(datetime):
    """A computer whose battery is empty."""

    @classmethod
    def now(cls, tz=None):
        return datetime(2001, 1, 1, tzinfo=tz or UTC)


def test_nothing_is_said_of_a_run_like_the_last(tmp_path, record_runs):
    record_runs(tmp_path, "01")
    assert list(changes(tmp_path, STUDY, TEXT, "mock")) == []
    assert list(changes(tmp_path / "new", STUDY, TEXT, "mock")) == []


def test_study_plate_and_clock_are_compared_with_the_last_run(tmp_path, record_runs, monkeypatch):
    record_runs(tmp_path, "01", "02")
    monkeypatch.setattr(changed_since, "datetime", Past)
    study, plate, clock = changes(tmp_path, STUDY, TEXT + "# later", "serial:/dev/ttyACM0")
    assert "the study 'biet2007' has changed since sub-01, sub-02" in study
    assert plate == "the plate was 'mock' in sub-02, but is now 'serial:/dev/ttyACM0'"
    assert clock.startswith("this computer's clock shows 2001-01-01 00:00 UTC, but ")


def test_another_study_of_the_folder_is_not_compared(tmp_path, record_runs):
    record_runs(tmp_path, "01", study_text=TEXT.replace('"biet2007"', '"other"', 1))
    assert list(changes(tmp_path, STUDY, TEXT, "scpi:x")) == []


@pytest.mark.parametrize("said", ["y", ""])
def test_run_asks_at_a_terminal_and_begins_only_on_a_yes(
    tmp_path, record_runs, monkeypatch, capsys, said
):
    record_runs(tmp_path, "01", study_text=TEXT + "# earlier")
    monkeypatch.setattr(sessions, "_begin", lambda *_, **__: 0)
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("builtins.input", lambda _: said)
    words = ["run", "biet2007", "--participant", "02", "--plate", "mock", "--out", str(tmp_path)]
    assert main(words) == (0 if said else 1)
    told = capsys.readouterr()
    assert "has changed since sub-01" in told.err
    assert ("not started" in told.out) is not bool(said)


def test_runs_without_a_whole_copy_are_counted(tmp_path, record_runs):
    data, disk = record_runs(tmp_path / "data", "01", "02"), tmp_path / "disk"
    first, second = journals(data)
    assert not_backed_up(data, None) == [first, second]
    disk.mkdir()
    copy = back_up(data, first, disk)
    assert not_backed_up(data, None) == [second]
    copy.write_bytes(copy.read_bytes()[:-1])
    assert not_backed_up(data, disk) == [first, second]
