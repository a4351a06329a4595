"""Who withdraws leaves nothing but the fact."""

import os
import re
import shutil
import stat

import pandas as pd
import pytest

from slipscale import commands
from slipscale.experiments.dataset import merging, withdrawal
from slipscale.experiments.dataset.backup import back_up
from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.journals import journals, read_runs
from slipscale.experiments.dataset.merging import merge
from slipscale.experiments.dataset.verification import verify
from slipscale.experiments.dataset.withdrawal import withdraw
from slipscale.experiments.dataset.withdrawn import Pending, note, replacement, withdrawn
from slipscale.experiments.journal.journal import FALLBACK, Journal
from slipscale.experiments.running.run_state import check_alike, participants
from slipscale.experiments.study.file import study_text
from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock


@pytest.fixture
def dataset(tmp_path, record_runs, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    folder = record_runs(tmp_path / "data", "01", "02")
    build_dataset(folder)
    (folder / "derivatives/slipscale").mkdir(parents=True)
    (folder / "derivatives/slipscale/estimates.csv").write_text("sub-01,5\n")
    return folder


def named(folder, label):
    """Return the files that name a participant, by name or in their text."""
    return [
        path.relative_to(folder).as_posix()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and (label in path.as_posix() or label in path.read_text("utf-8"))
    ]


def test_nothing_of_them_is_left_and_the_others_are_whole(dataset):
    before = read_runs(dataset)[0][1].gathered
    withdraw(dataset, "01")
    assert named(dataset, "sub-01") == []
    assert list(pd.read_csv(dataset / "participants.tsv", sep="\t")["participant_id"]) == ["sub-02"]
    assert read_runs(dataset)[0][0].gathered == before
    assert verify(dataset) == []


def test_copies_of_other_programs_are_named(dataset):
    journal = journals(dataset)[0]
    left = [
        dataset / "participants.tsv~",
        dataset / "sourcedata/old.jsonl.bak",
        dataset / "before.zip",
        dataset / "people.xlsx",
        dataset / ".git",
        dataset / "sub-01 to sub-02",
        dataset / "code/sub-01_and_sub-02.R",
    ]
    shutil.copy(dataset / "participants.tsv", left[0])
    shutil.copy(journal, left[1])
    left[2].write_bytes(b"PK")
    left[3].write_bytes(b"PK")
    left[4].mkdir()
    left[5].mkdir()
    left[6].parent.mkdir(exist_ok=True)
    left[6].write_text("plot(1)\n", encoding="utf-8")
    assert sorted(withdraw(dataset, "01").left) == sorted(left)
    assert all(path.exists() for path in left)


def test_the_command_says_no_if_something_may_be_left(dataset, capsys):
    shutil.copy(dataset / "participants.tsv", dataset / "participants.tsv~")
    assert commands.main(["data", "withdraw", str(dataset), "--participant", "01", "--yes"]) == 1
    told = capsys.readouterr()
    assert f"rows removed: {dataset / 'participants.tsv'}\n" in told.out
    assert "participants.tsv~ may still hold data from participant 01" in told.err


def test_nothing_is_left_of_another_participant(dataset):
    assert withdraw(dataset, "02").left == []


@pytest.mark.skipif(os.name == "nt", reason="links need rights on Windows")
def test_a_link_is_removed_and_its_target_named(dataset, tmp_path):
    elsewhere = tmp_path / "elsewhere"
    (dataset / "sub-01").rename(elsewhere)
    (dataset / "sub-01").symlink_to(elsewhere)
    assert withdraw(dataset, "01").left == [elsewhere]
    assert not (dataset / "sub-01").is_symlink()
    assert elsewhere.is_dir()


@pytest.mark.parametrize("place", ["sub-01", "sourcedata", ".."])
def test_a_folder_in_or_around_a_data_set_is_refused(dataset, place):
    message = f"is not a data set; withdraw the participant from {dataset}"
    with pytest.raises(UserError, match=re.escape(message)):
        withdraw((dataset / place).resolve(), "01")
    assert journals(dataset)[0].exists()


def test_the_number_is_never_offered_again_and_a_replacement_takes_the_place(dataset, plan):
    withdraw(dataset, "01")
    assert withdrawn(dataset) == ["01"]
    assert participants(dataset) == ["01", "02"]
    for label in ("01", "1"):
        with pytest.raises(UserError, match="the replacement is participant R01"):
            check_alike(dataset, label)
    check_alike(dataset, replacement("01"))
    assert plan(participant=replacement("01")).row == plan(participant="01").row


def test_a_journal_that_was_kept_elsewhere_goes_too(dataset, plan, tmp_path):
    kept = tmp_path / "home" / FALLBACK / "x"
    path = plan().journal_path(kept)
    path.parent.mkdir(parents=True)
    path.write_bytes(plan().journal_path(dataset).read_bytes())
    withdraw(dataset, "01")
    assert not kept.exists()


def test_when_all_have_withdrawn_no_answer_about_them_is_left(dataset):
    withdraw(dataset, "01")
    withdraw(dataset, "02")
    assert withdrawn(dataset) == ["01", "02"]
    assert not (dataset / "participants.tsv").exists()


def test_the_command_removes_only_when_told_twice(dataset, capsys):
    words = ["data", "withdraw", str(dataset), "--participant", "02"]
    assert commands.main(words) == 1
    assert "would be removed" in capsys.readouterr().out
    assert verify(dataset) == []
    assert commands.main([*words, "--yes"]) == 0
    assert "--participant R02" in capsys.readouterr().out
    assert commands.main([*words, "--yes"]) == 2


class Killed(BaseException):
    """The process is gone."""


@pytest.mark.parametrize("step", range(8))
def test_a_withdrawal_that_is_killed_at_any_step_can_be_ended(
    dataset, plan, tmp_path, monkeypatch, step
):
    kept = tmp_path / "home" / FALLBACK / "x"
    path = plan().journal_path(kept)
    path.parent.mkdir(parents=True)
    path.write_bytes(plan().journal_path(dataset).read_bytes())
    (tmp_path / "disk").mkdir()
    for label in ("01", "02"):
        back_up(dataset, plan(participant=label).journal_path(dataset), tmp_path / "disk")
    build_dataset(tmp_path / "disk/data")
    calls = []

    def dying(call):
        def counted(*arguments, **options):
            calls.append(call)
            if len(calls) == step + 1:
                raise Killed
            return call(*arguments, **options)

        return counted

    with monkeypatch.context() as life:
        life.setattr(withdrawal.shutil, "rmtree", dying(withdrawal.shutil.rmtree))
        life.setattr(withdrawal, "build_dataset", dying(withdrawal.build_dataset))
        with pytest.raises(Killed):
            withdraw(dataset, "01")
    assert any("is not finished" in problem.what for problem in verify(dataset))
    withdraw(dataset, "01")
    assert named(dataset, "sub-01") == named(tmp_path / "disk", "sub-01") == []
    assert verify(dataset) == verify(tmp_path / "disk/data") == []
    assert not kept.exists()
    assert not list(tmp_path.rglob("sub-01*"))
    assert withdrawn(dataset) == ["01"]
    with pytest.raises(UserError, match="contains no data from this participant"):
        withdraw(dataset, "01")


def test_a_withdrawal_that_an_earlier_version_left_unfinished_is_finished(dataset, tmp_path, plan):
    """It noted the label first, and could be killed before the backup's tables were rebuilt."""
    (tmp_path / "disk").mkdir()
    for label in ("01", "02"):
        back_up(dataset, plan(participant=label).journal_path(dataset), tmp_path / "disk")
    build_dataset(tmp_path / "disk/data")
    people = (tmp_path / "disk/data/participants.tsv").read_text()
    withdraw(dataset, "01")
    (tmp_path / "disk/data/participants.tsv").write_text(people)
    withdraw(dataset, "01")
    assert named(tmp_path / "disk", "sub-01") == []


@pytest.fixture
def merged(dataset, tmp_path, record_runs):
    """Return the data set, another one, and the set that both were merged into."""
    other = record_runs(tmp_path / "other", "03")
    merge(dataset, other, tmp_path / "both")
    return dataset, other, tmp_path / "both"


def test_a_withdrawal_reaches_the_set_that_a_data_set_was_merged_into(merged, tmp_path):
    dataset, other, both = merged
    (tmp_path / "disk").mkdir()
    back_up(both, journals(both)[0], tmp_path / "disk")
    withdraw(dataset, "01")
    assert named(both, "sub-01") == named(tmp_path / "disk", "sub-01") == []
    assert withdrawn(both) == ["01"]
    assert verify(both) == []
    assert len(journals(other)) == 1


def test_a_withdrawal_from_a_merged_set_names_the_source_that_holds_them(merged, capsys):
    dataset, other, both = merged
    assert commands.main(["data", "withdraw", str(both), "--participant", "01", "--yes"]) == 0
    told = capsys.readouterr().err
    assert f"slipscale data withdraw {dataset} --participant 01 --yes" in told
    assert str(other) not in told
    assert named(both, "sub-01") == []


def test_a_merged_set_that_is_gone_is_named_before_anything_is_removed(merged):
    dataset, _, both = merged
    shutil.rmtree(both)
    with pytest.raises(
        UserError, match=r"both is not available.*remove its line from .*merged\.json"
    ):
        withdraw(dataset, "01")
    assert len(journals(dataset)) == 2


def test_what_an_interrupted_merge_left_goes_too(dataset, tmp_path, record_runs, monkeypatch):
    other = record_runs(tmp_path / "other", "03")

    def killed(_folder):
        raise Killed

    with monkeypatch.context() as life:
        life.setattr(merging, "build_dataset", killed)
        with pytest.raises(Killed):
            merge(dataset, other, tmp_path / "both")
    assert not (tmp_path / "both").exists()
    withdraw(dataset, "01")
    assert list(tmp_path.rglob("sub-01*")) == []
    merge(dataset, other, tmp_path / "both")
    assert verify(tmp_path / "both") == []


def test_sets_are_not_merged_while_a_withdrawal_is_unfinished(dataset, tmp_path, record_runs):
    other = record_runs(tmp_path / "other", "03")
    note(dataset, "02", Pending())
    with pytest.raises(UserError, match="withdrawal of participant 02 is not finished"):
        merge(dataset, other, tmp_path / "both")


def test_nobody_withdraws_while_their_session_runs(dataset, plan):
    path = plan().journal_path(dataset)
    with (
        Journal.reopen(path, VirtualClock()),
        pytest.raises(UserError, match="a session of this participant is running"),
    ):
        withdraw(dataset, "01")
    assert path.exists()


@pytest.mark.skipif(os.name != "posix", reason="elsewhere files have no such modes")
@pytest.mark.parametrize("private", [True, False])
def test_files_are_their_owners_unless_the_study_says_otherwise(tmp_path, private):
    from slipscale.experiments.running.pilot import pilot_plans, run_pilot

    study = tmp_path / "study.toml"
    line = "" if private else "private_files = false\n"
    study.write_text(line + study_text("biet2007"), encoding="utf-8")
    plans = pilot_plans(str(study), participants=1, seed=1, language=None)
    mask = os.umask(0o022)
    try:
        run_pilot(tmp_path / "data", plans, tell=lambda _: None)
    finally:
        os.umask(mask)
    modes = {
        stat.S_IMODE(path.stat().st_mode)
        for path in (tmp_path / "data").rglob("*")
        if path.is_file()
    }
    assert modes == {0o600 if private else 0o644}


@pytest.mark.parametrize(
    "name",
    [
        "sub-01 (1)/beh/sub-01_task-x_run-01_beh.tsv",
        "sub-01 - Copy.tsv",
        "sourcedata/sub-02/sub-01_run-01_journal (conflicted copy).jsonl",
        "participants (1).tsv",
        "participants (conflicted copy 2026-11-28).tsv",
    ],
)
def test_copies_that_other_programs_made_are_withdrawn_too(dataset, name):
    (dataset / name).parent.mkdir(parents=True, exist_ok=True)
    (dataset / name).write_text("participant_id\tage\nsub-01\t23\nsub-02\t24\nsub-010\t25\n")
    withdraw(dataset, "01")
    assert [each for each in named(dataset, "sub-01") if "sub-010" not in each] == [
        each for each in [name] if name.startswith("participants")
    ]
    if name.startswith("participants"):
        assert (dataset / name).read_text() == "participant_id\tage\nsub-02\t24\nsub-010\t25\n"


def test_others_with_a_longer_label_stay(dataset):
    (dataset / "sub-010").mkdir()
    (dataset / "sub-010" / "notes.txt").write_text("kept")
    withdraw(dataset, "01")
    assert (dataset / "sub-010" / "notes.txt").read_text() == "kept"
