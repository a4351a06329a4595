"""Backups hold each run's journal, byte for byte; who withdraws goes from them too."""

import pytest

from slipscale.experiments.dataset import backup as module
from slipscale.experiments.dataset.backup import back_up, backups
from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.journals import journals
from slipscale.experiments.dataset.verification import verify
from slipscale.experiments.dataset.withdrawal import withdraw
from slipscale.faults import UserError


@pytest.fixture
def dataset(tmp_path, record_runs):
    (tmp_path / "disk").mkdir()
    return record_runs(tmp_path / "data", "01", "02")


def copies(dataset, disk):
    return [back_up(dataset, path, disk) for path in journals(dataset)]


def test_a_backup_is_a_data_set_of_its_own(dataset, tmp_path):
    made = copies(dataset, tmp_path / "disk")
    assert [path.read_bytes() for path in made] == [p.read_bytes() for p in journals(dataset)]
    build_dataset(tmp_path / "disk/data")
    assert verify(tmp_path / "disk/data") == []
    assert backups(dataset) == [tmp_path / "disk/data"]


def test_a_run_that_went_on_replaces_its_beginning(dataset, tmp_path):
    first, _ = copies(dataset, tmp_path / "disk")
    whole = first.read_bytes()
    first.write_bytes(whole[:2000])
    copies(dataset, tmp_path / "disk")
    assert first.read_bytes() == whole


def test_another_run_in_its_place_is_never_overwritten(dataset, tmp_path):
    first, _ = copies(dataset, tmp_path / "disk")
    first.write_bytes(b"another laboratory's\n")
    with pytest.raises(UserError, match="contains another run"):
        copies(dataset, tmp_path / "disk")
    assert first.read_bytes() == b"another laboratory's\n"


def test_a_medium_that_gives_back_something_else_is_told(dataset, tmp_path, monkeypatch):
    class Faulty:
        def __init__(self, content):
            self.content = content

        def digest(self):
            Faulty.calls = getattr(Faulty, "calls", 0) + 1
            return Faulty.calls

    monkeypatch.setattr(module, "sha256", Faulty)
    with pytest.raises(UserError, match="may be faulty"):
        copies(dataset, tmp_path / "disk")


@pytest.mark.parametrize("place", ["gone", "data/inside"])
def test_a_folder_that_cannot_be_a_backup_is_refused(dataset, tmp_path, place):
    if place != "gone":
        (tmp_path / place).mkdir(parents=True)
    with pytest.raises(UserError, match=r"no such folder|is inside the data set"):
        copies(dataset, tmp_path / place)


def test_who_withdraws_goes_from_the_backup_and_its_tables_too(dataset, tmp_path):
    copies(dataset, tmp_path / "disk")
    build_dataset(tmp_path / "disk/data")
    withdraw(dataset, "01")
    left = [path for path in (tmp_path / "disk").rglob("*") if "sub-01" in path.name]
    assert left == []
    assert "sub-01" not in (tmp_path / "disk/data/participants.tsv").read_text()
    assert journals(tmp_path / "disk/data")


def test_withdrawing_waits_for_a_backup_that_is_not_there(dataset, tmp_path):
    copies(dataset, tmp_path / "disk")
    (tmp_path / "disk").rename(tmp_path / "unplugged")
    with pytest.raises(UserError, match="connect its disk"):
        withdraw(dataset, "01")
    assert len(journals(dataset)) == 2


def test_a_list_of_backups_that_cannot_be_read_is_told(dataset):
    (dataset / "sourcedata/backups.json").write_text("{")
    with pytest.raises(UserError, match=r"backups\.json: cannot be read"):
        withdraw(dataset, "01")


def test_the_folder_that_the_data_set_lies_in_is_no_backup_of_it(dataset):
    """The copy would be the journal itself."""
    with pytest.raises(UserError, match="contains the data set itself"):
        back_up(dataset, journals(dataset)[0], dataset.parent)
