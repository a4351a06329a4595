"""A participant is excluded by hand with a reason, which stays with their journals."""

import json
import shutil

import pytest

from slipscale.experiments.dataset.hand_exclusions import RECORD, decide, excluded_by_hand
from slipscale.experiments.dataset.merging import merge
from slipscale.experiments.dataset.verification import verify
from slipscale.experiments.dataset.withdrawal import withdraw
from slipscale.faults import UserError


@pytest.fixture
def dataset(tmp_path, record_runs, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    return record_runs(tmp_path / "data", "01", "02")


def exclude(dataset, label, reason="wore a glove", *, excluded=True, results_seen=False):
    decide(dataset, label, excluded=excluded, reason=reason, results_seen=results_seen)


def test_every_decision_is_kept_and_the_last_one_counts(dataset):
    exclude(dataset, "02", "wore\n a glove")
    assert {who: each.reason for who, each in excluded_by_hand(dataset).items()} == {
        "02": "wore a glove"
    }
    exclude(dataset, "02", "it was a bandage", excluded=False, results_seen=True)
    assert excluded_by_hand(dataset) == {}
    kept = json.loads((dataset / "sourcedata/sub-02" / RECORD).read_text())
    assert [(each["excluded"], each["results_seen"]) for each in kept] == [
        (True, False),
        (False, True),
    ]


@pytest.mark.parametrize(
    "label, reason, excluded, complaint",
    [
        ("09", "x", True, "contains no data from this participant"),
        ("01", "  ", True, "expected a reason"),
        ("01", "x", False, "is not excluded by hand"),
        ("02", "x", True, "is already excluded"),
    ],
)
def test_what_cannot_be_decided_is_refused_and_nothing_is_written(
    dataset, label, reason, excluded, complaint
):
    exclude(dataset, "02")
    with pytest.raises(UserError, match=complaint):
        exclude(dataset, label, reason, excluded=excluded)
    assert list(excluded_by_hand(dataset)) == ["02"]
    assert not (dataset / "sourcedata/sub-01" / RECORD).exists()


@pytest.mark.parametrize("content", ["", "[]", "{}", '[{"excluded": true}]', "\0"])
def test_a_file_that_is_no_list_of_decisions_is_refused_by_name(dataset, content):
    path = dataset / "sourcedata/sub-01" / RECORD
    path.write_text(content)
    with pytest.raises(UserError, match=RECORD):
        excluded_by_hand(dataset)
    with pytest.raises(UserError, match=RECORD):
        exclude(dataset, "01")
    assert path.read_text() == content


def test_a_merge_takes_decisions_along_and_refuses_two_that_differ(tmp_path, record_runs, dataset):
    # The same run of 02 in both: another recording differs if it begins in another second.
    shutil.copytree(dataset, tmp_path / "other")
    other = record_runs(tmp_path / "other", "03")
    exclude(other, "03")
    exclude(dataset, "02")
    merge(dataset, other, tmp_path / "both")
    assert list(excluded_by_hand(tmp_path / "both")) == ["02", "03"]
    exclude(other, "02", "another reason")
    with pytest.raises(
        UserError, match=rf"sub-02/{RECORD}: this file differs between the data sets"
    ):
        merge(dataset, other, tmp_path / "again")


def test_a_withdrawal_removes_the_decision_and_the_data_set_still_agrees(dataset):
    exclude(dataset, "01")
    exclude(dataset, "02")
    withdraw(dataset, "01")
    assert list(excluded_by_hand(dataset)) == ["02"]
    assert verify(dataset) == []
