"""A build removes no row: what only the tables hold is kept and reported."""

import shutil

import pandas as pd
import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.journals import journals
from slipscale.experiments.dataset.merging import merge
from slipscale.experiments.dataset.verification import verify
from slipscale.experiments.study.file import study_text
from slipscale.faults import UserError
from tools.campaigns.torture.upkeep import QUESTIONNAIRE

TABLE = "sub-01/beh/sub-01_task-magnitudeestimation_run-01_beh.tsv"
SHARED = ("participants.tsv", "phenotype/habits.tsv")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory, record_runs):
    """Pilots: their sidecars do not say how many records there were."""
    text = study_text("biet2007") + QUESTIONNAIRE
    folder = record_runs(tmp_path_factory.mktemp("recorded"), "01", "02", study_text=text)
    assert build_dataset(folder) == []
    return folder


@pytest.fixture
def dataset(recorded, tmp_path):
    return shutil.copytree(recorded, tmp_path / "data")


def frame(path):
    """Return a table's answers; whether the person's runs are complete may change."""
    whole = pd.read_csv(path, sep="\t", keep_default_na=False, dtype=str)
    return whole.drop(columns="complete", errors="ignore")


def truncate(path):
    """Keep the answers about the person: their participants' row stays, others become n/a."""
    lines = path.read_bytes().splitlines(keepends=True)
    last = next(i for i, line in enumerate(lines) if b'"Ask"' in line)
    path.write_bytes(b"".join(lines[:last]))


LOSSES = {
    "removed": lambda path: path.unlink(),
    "emptied": lambda path: path.write_bytes(b""),
    "truncated": truncate,
    "header torn": lambda path: path.write_bytes(path.read_bytes()[:30]),
}


@pytest.mark.parametrize("loss", LOSSES)
def test_answers_whose_journal_is_lost_stay_in_all_tables(dataset, loss):
    before = {name: frame(dataset / name) for name in SHARED}
    own, cut = (dataset / TABLE).read_bytes(), loss == "truncated"  # then the journal is named
    LOSSES[loss](journals(dataset)[0])
    for _ in range(2):  # nothing is worn away
        problems = build_dataset(dataset)
        assert {each.file for each in problems} >= {*SHARED, TABLE} - ({TABLE} if cut else set())
        assert all(each.place == "sub-01" for each in problems if each.file in SHARED)
        for name in SHARED:
            now = frame(dataset / name)
            pd.testing.assert_frame_equal(now, before[name])
        assert (dataset / TABLE).read_bytes() == own
    assert verify(dataset)


def test_a_pilots_table_that_would_shrink_is_left_and_named(dataset):
    before = (dataset / TABLE).read_bytes()
    path = journals(dataset)[0]
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[: len(lines) // 2]))
    problems = build_dataset(dataset)
    (told,) = [each for each in problems if each.file == TABLE]
    assert f"has {len(before.splitlines()) - 1} rows, but only" in told.what
    assert (dataset / TABLE).read_bytes() == before
    assert TABLE in {each.file for each in verify(dataset)}


def test_the_next_participants_rows_are_added_to_a_table_with_kept_ones(dataset, record_runs):
    journals(dataset)[0].unlink()
    text = study_text("biet2007") + QUESTIONNAIRE
    record_runs(dataset, "03", study_text=text)
    build_dataset(dataset)
    for name in SHARED:
        labels = list(frame(dataset / name)["participant_id"])
        assert labels == ["sub-01", "sub-02", "sub-03"]


def test_a_row_deleted_by_hand_is_not_kept(dataset):
    shutil.rmtree(dataset / "sub-01")
    journals(dataset)[0].unlink()
    for name in SHARED:
        rows = (dataset / name).read_text().splitlines(keepends=True)
        (dataset / name).write_text("".join(row for row in rows if "sub-01" not in row))
    assert build_dataset(dataset) == []
    assert verify(dataset) == []


def test_a_merge_is_refused_while_a_source_holds_rows_without_a_journal(
    dataset, tmp_path, record_runs
):
    other = record_runs(tmp_path / "other", "03", study_text=study_text("biet2007") + QUESTIONNAIRE)
    journals(dataset)[0].unlink()
    with pytest.raises(
        UserError, match=r"participants\.tsv: sub-01: this row is not in any journal"
    ):
        merge(dataset, other, tmp_path / "both")
    assert not (tmp_path / "both").exists()
