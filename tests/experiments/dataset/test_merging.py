"""Two laboratory computers' folders become one, or every contradiction is told."""

import pytest

from slipscale.commands import main
from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.journals import journals, read_runs
from slipscale.experiments.dataset.merging import merge
from slipscale.experiments.dataset.verification import verify
from slipscale.experiments.dataset.withdrawal import withdraw
from slipscale.experiments.dataset.withdrawn import withdrawn
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.study.file import study_text
from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock

TEXT = study_text("biet2007")


@pytest.fixture
def folders(tmp_path, record_runs):
    """Return a function that records both folders, and the place of the third."""

    def record(ours, theirs, **changes):
        one, other = tmp_path / "a", tmp_path / "b"
        record_runs(one, *ours)
        record_runs(other, *theirs, **changes)
        build_dataset(one)
        build_dataset(other)
        return one, other, tmp_path / "both"

    return record


def test_the_new_data_set_holds_the_runs_of_both_and_both_stay(folders):
    one, other, both = folders(["01"], ["02"])
    before = [path.read_bytes() for path in (*journals(one), *journals(other))]
    merged = merge(one, other, both)
    assert (merged.runs, merged.notes, merged.problems) == (2, (), ())
    assert [path.read_bytes() for path in journals(both)] == before
    assert verify(both) == []


@pytest.mark.parametrize("place", [".", "in", "sub-01/in"])
def test_nothing_is_written_into_a_source(folders, place):
    one, other, _ = folders(["01"], ["02"])
    with pytest.raises(UserError, match="is in a source, which stays unchanged"):
        merge(one, other, other / place)


def test_the_same_run_in_both_is_taken_once_and_the_longer(folders):
    one, other, both = folders(["01"], ["02"])
    path = one / journals(other)[0].relative_to(other)
    path.parent.mkdir()
    path.write_bytes(journals(other)[0].read_bytes())
    path.write_bytes(b"".join(path.read_bytes().splitlines(keepends=True)[:30]))
    merge(one, other, both)
    assert [run.complete for run in read_runs(both)[0]] == [True, True]


@pytest.mark.parametrize(
    "changes, complaint",
    [
        ({"mode": "participant"}, "contains pilot data.*participant data"),
        ({"seed": 1}, "was run with different seeds: 1, 2007"),
        (
            {"study_text": TEXT.replace("repetitions = 1", "repetitions = 2")},
            "the study files in the two data sets differ",
        ),
        ({"study_text": TEXT.replace('"biet2007"', '"other"')}, "contains study biet2007"),
    ],
)
def test_what_contradicts_is_refused_and_nothing_is_written(folders, changes, complaint):
    one, other, both = folders(["01"], ["02"], **changes)
    with pytest.raises(UserError, match=f"(?s){complaint}"):
        merge(one, other, both)
    assert not both.exists()


def test_two_people_under_one_number_are_refused(folders):
    one, other, both = folders(["01"], ["01"], seed=5)
    with pytest.raises(UserError, match=r"2 contradictions(?s:.*)two people with the same number"):
        merge(one, other, both)


def test_one_person_under_two_labels_is_refused(folders):
    one, other, both = folders(["01"], ["001"])
    with pytest.raises(UserError, match="001 and 01 would be mistaken for the same person"):
        merge(one, other, both)


def test_who_withdrew_from_one_must_be_gone_from_both(folders):
    one, other, both = folders(["01", "02"], ["01", "03"])
    withdraw(one, "01")
    with pytest.raises(UserError, match=r"01 withdrew from .*slipscale data withdraw"):
        merge(one, other, both)
    withdraw(other, "01")
    merge(one, other, both)
    assert withdrawn(both) == ["01"]


def test_a_person_with_runs_in_both_is_noted(folders):
    one, other, both = folders(["01"], ["01"], run="02")
    assert merge(one, other, both).notes == (
        "participant 01 has runs in both data sets; they are treated as the same person",
    )


def test_files_that_people_wrote_come_along_or_contradict(folders):
    one, other, both = folders(["01"], ["02"])
    (one / "code/verbal_codes.tsv").write_text("mine\n")
    (other / "code/verbal_codes.tsv").write_text("theirs\n")
    with pytest.raises(UserError, match=r"verbal_codes\.tsv: this file differs"):
        merge(one, other, both)
    (other / "code/verbal_codes.tsv").unlink()
    merge(one, other, both)
    assert (both / "code/verbal_codes.tsv").read_text() == "mine\n"


def test_a_folder_in_use_or_without_journals_is_refused(folders, tmp_path, capsys):
    one, other, both = folders(["01"], ["02"])
    words = ["data", "merge", str(one), str(other), "--out", str(both)]
    with Journal.reopen(journals(other)[0], VirtualClock()):
        assert main(words) == 2
        assert "a session is running" in capsys.readouterr().err
    assert main(["data", "merge", str(tmp_path), str(other), "--out", str(both)]) == 2
    assert "no journals" in capsys.readouterr().err
    assert main(words) == 0
    assert "2 runs from" in capsys.readouterr().out
    assert main(words) == 2
    assert "is not an empty folder" in capsys.readouterr().err
