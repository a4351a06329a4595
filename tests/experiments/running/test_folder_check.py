"""What `slipscale check` says of the folder: locks, damaged journals, a study that has changed."""

import portalocker
import pytest

from slipscale.experiments.running.preflight import PlannedSession, check_folder
from slipscale.experiments.study.file import study_text


@pytest.fixture
def planned(tmp_path, record_runs):
    record_runs(tmp_path / "data", "01")
    return PlannedSession(study="biet2007", plate="mock", out=tmp_path / "data")


def test_a_sound_folder_passes(planned):
    finding = check_folder(planned)
    assert (finding.passed, finding.remedy) == (True, "")


def test_a_file_system_without_locks_is_told(planned, monkeypatch):
    def refuse(_stream, _flags):
        raise portalocker.LockException(OSError(95, "Operation not supported"))

    monkeypatch.setattr(portalocker, "lock", refuse)
    finding = check_folder(planned)
    assert finding.passed is None
    assert "does not support locks" in finding.remedy


@pytest.mark.parametrize("place", [0, 30])
def test_a_damaged_journal_is_named(planned, place):
    path = planned.out / "sourcedata/sub-01/sub-01_run-01_journal.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    lines[place] = lines[place].replace(b'"kind"', b'"kinb"')
    path.write_bytes(b"".join(lines))
    finding = check_folder(planned)
    assert finding.passed is None
    assert "damaged: sourcedata/sub-01/sub-01_run-01_journal.jsonl" in finding.remedy


def test_a_study_of_the_same_name_that_has_changed_is_told(planned, tmp_path):
    other = tmp_path / "study.toml"
    other.write_text(study_text("biet2007").replace("repetitions = 2", "repetitions = 3") + "\n")
    finding = check_folder(PlannedSession(study=str(other), plate="mock", out=planned.out))
    assert finding.passed is None
    assert "the study 'biet2007' has changed since sub-01" in finding.remedy
