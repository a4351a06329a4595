"""Data sets under DataLad: locked files are links into `.git/annex`."""

import shutil

import pytest

from slipscale import commands
from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.verification import verify


def lock(path, dataset):
    """Move a file into the annex and leave a link, as `git annex add` does."""
    kept = dataset / ".git/annex/objects" / path.name / path.name
    kept.parent.mkdir(parents=True)
    shutil.move(path, kept)
    kept.chmod(0o444)
    path.symlink_to(kept)
    return kept


@pytest.fixture
def annexed(laboratory, plan):
    """Return a data set with an interrupted run, of which all files are locked."""
    laboratory.run()
    journal = plan().journal_path(laboratory.folder)
    journal.write_bytes(b"".join(journal.read_bytes().splitlines(keepends=True)[:60]))
    build_dataset(laboratory.folder)
    dataset = laboratory.folder
    attributes = dataset / ".gitattributes"
    attributes.write_text("* annex.backend=MD5E\n" + attributes.read_text())
    files = [path for path in dataset.rglob("*") if path.is_file() and path != attributes]
    return dataset, {path: lock(path, dataset) for path in files}


def test_locked_files_are_read_verified_and_replaced_by_new_ones(annexed):
    dataset, locked = annexed
    before = {path: kept.read_bytes() for path, kept in locked.items()}
    assert verify(dataset) == []
    assert build_dataset(dataset) == []
    assert {path: kept.read_bytes() for path, kept in locked.items()} == before
    assert (dataset / ".gitattributes").read_text().startswith("* annex.backend=MD5E\n*.jsonl")
    (dataset / ".gitattributes").write_text("* annex.backend=MD5E")
    assert [each.file for each in verify(dataset)] == [".gitattributes"]
    build_dataset(dataset)
    assert (dataset / ".gitattributes").read_text().startswith("* annex.backend=MD5E\n*.jsonl")


def test_a_locked_journal_is_not_resumed_and_the_way_is_named(annexed, capsys):
    dataset, _ = annexed
    (journal,) = dataset.glob("sourcedata/sub-01/*.jsonl")
    before = journal.read_bytes()
    assert commands.main(["resume", str(journal)]) == 2
    said = capsys.readouterr().err
    assert f"is locked by git-annex; unlock it first: git annex unlock {journal}" in said
    assert journal.read_bytes() == before
    kept = journal.resolve()
    journal.unlink()
    shutil.copyfile(kept, journal)  # what `git annex unlock` does
    assert commands.main(["resume", str(journal)]) == 0
    assert journal.stat().st_size > len(before)
