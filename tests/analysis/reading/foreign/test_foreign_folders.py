"""Folders of other laboratories in BIDS format: one task, with labels from file names."""

import pandas as pd
import pytest

from slipscale.analysis.load import load
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.faults import UserError

ROWS = pd.DataFrame({"level": [20, 200, 2000, 20_000], "loudness": [5.0, 20.0, 90.0, 400.0]})


def mapping(table=None, participant="participant_id", **columns):
    columns |= {"participant": participant, "stimulus": "level", "response": "loudness"}
    return parse_mapping({"columns": columns, "table": table or {}}, "here")


@pytest.mark.parametrize("suffix", ["beh", "events"])
def test_plain_bids_tables_read_with_the_participant_from_their_names(tmp_path, suffix):
    for who in ("01", "02"):
        folder = tmp_path / f"sub-{who}" / "beh"
        folder.mkdir(parents=True)
        frame = ROWS.assign(onset=0.0, duration=1.0)
        frame.to_csv(folder / f"sub-{who}_task-loud_{suffix}.tsv", sep="\t", index=False)
    data = load(tmp_path, mapping())
    assert data.people == {"sub-01", "sub-02"}
    assert len(data.estimates) == 8


def bids(tmp_path, *names):
    for number, name in enumerate(names, start=1):
        folder = tmp_path / name.partition("_")[0] / "beh"
        folder.mkdir(parents=True, exist_ok=True)
        frame = ROWS.assign(trial=range(1, 5))
        frame["loudness"] += number
        frame.to_csv(folder / f"{name}.tsv", sep="\t", index=False)
    return tmp_path


def test_of_several_tasks_in_a_bids_folder_one_is_named(tmp_path):
    folder = bids(tmp_path, *(f"sub-{who}_task-{task}_beh" for who in "12" for task in "ab"))
    found = mapping()
    with pytest.raises(UserError, match=r"contains several tasks: a, b; expected .*--task"):
        load(folder, found)
    with pytest.raises(UserError, match=r"--task c: .* contains the tasks a, b"):
        load(folder, found, task="c")
    data = load(folder, found, task="b")
    assert len(data.estimates) == 8
    assert {source.name for source in data.sources} == {
        f"sub-{who}/beh/sub-{who}_task-b_beh.tsv" for who in "12"
    }


def test_session_and_run_of_a_bids_table_are_in_its_name(tmp_path):
    names = [f"sub-1_ses-{ses}_task-a_run-{run}_beh" for ses in "xy" for run in "12"]
    folder = bids(tmp_path, *names)
    for own in ({}, {"run": "run", "session": "session"}, {"run": "run", "session": "ses"}):
        data = load(folder, mapping(trial="trial", **own))
        assert data.problems == ()
        found = data.estimates[["session", "run"]].astype(str).drop_duplicates()
        assert found.to_numpy().tolist() == [[ses, run] for ses in "xy" for run in "12"]
    second = mapping(participant="sub", table={"only": {"run": "2"}})
    assert set(load(folder, second).estimates["run"]) == {"2"}


def test_two_tables_of_one_bids_run_are_one(tmp_path):
    folder = bids(tmp_path, "sub-1_task-a_beh", "sub-1_task-a_events", "sub-2_task-a_events")
    other = folder / "sub-2/beh/sub-2_task-a_beh.tsv"
    other.write_text("onset\n1\n")
    data = load(folder, mapping())
    assert [source.name.rpartition("/")[2] for source in data.sources] == [
        "sub-1_task-a_beh.tsv",
        "sub-2_task-a_events.tsv",
    ]
    assert "2 runs have two tables" in data.problems[0]
