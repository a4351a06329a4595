"""The journal's file or folder goes in mid-session: nothing written is lost."""

import os
import shutil
from pathlib import Path

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.journal import journal as module
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.journal.reading import read_records
from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock

pytestmark = pytest.mark.skipif(os.name != "posix", reason="elsewhere an open file cannot go")

PLACE = Path("data/sourcedata/sub-01/sub-01_run-01_journal.jsonl")


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    return tmp_path / "home"


GOES = {
    "file removed": lambda path: path.unlink(),
    "file renamed": lambda path: path.rename(path.with_name("other")),
    "folder removed": lambda path: shutil.rmtree(path.parents[2]),
    "folder renamed": lambda path: path.parents[2].rename(path.parents[3] / "moved"),
    "another file in its place": lambda path: (path.unlink(), path.write_text("")),
}


@pytest.mark.parametrize("goes", GOES.values(), ids=GOES)
def test_all_until_then_and_all_that_follows_is_in_a_fallback_file_that_is_named(
    tmp_path, goes, home
):
    told = []
    with Journal.create(tmp_path / PLACE, VirtualClock()) as journal:
        journal.tell = told.append
        journal.write("header", format=2)
        journal.write("begin", step=0)
        goes(tmp_path / PLACE)
        journal.write("done", step=0)
        journal.write("end")
    assert journal.lost == tmp_path / PLACE
    assert journal.path.is_relative_to(home)
    records, _ = read_records(journal.path)
    assert [record.kind for record in records] == ["header", "begin", "done", "end"]
    assert records == journal.records
    (sentence,) = told
    assert str(journal.path) in sentence
    assert str(tmp_path / PLACE) in sentence


def test_a_fallback_that_goes_as_well_is_followed_by_another(tmp_path):
    with Journal.create(tmp_path / PLACE, VirtualClock()) as journal:
        journal.tell = lambda _: None
        for number in range(3):
            journal.write("header" if not number else "begin", format=2)
            journal.path.unlink()
        journal.write("end")
    assert [record.number for record in read_records(journal.path)[0]] == [0, 1, 2, 3]


def test_where_no_place_is_left_the_session_ends_with_a_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "fallback_folders", list)
    with Journal.create(tmp_path / PLACE, VirtualClock()) as journal:
        journal.write("header", format=2)
        journal.path.unlink()
        with pytest.raises(UserError, match="no fallback folder can be written; it had 1 records"):
            journal.write("end")


def test_a_session_whose_folder_goes_is_whole_in_the_fallback(laboratory, plan, monkeypatch):
    append = Journal.append
    gone = []

    def losing(journal, kind, **data):
        if len(journal.records) == 50 and not gone:
            gone.append(journal)
            shutil.rmtree(laboratory.folder)
        return append(journal, kind, **data)

    monkeypatch.setattr(Journal, "append", losing)
    assert laboratory.run() == "complete"
    kept = gone[0].path.parents[2]
    assert build_dataset(kept) == []
    assert len(list(kept.glob("sub-01/beh/*_beh.tsv"))) == 2
