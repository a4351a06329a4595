"""Withdraw a participant: remove all data from the participant, and record the withdrawal.

A withdrawal applies to the data set, its backups and the merged sets that include the data set. All
affected folders are recorded before the first file is removed, and each step can be repeated. An
interrupted withdrawal can therefore be finished with the same command.

A withdrawn participant's label is not used again. The replacement's label is R followed by the old
label. Both labels end in the same number, which determines the position in the counterbalancing.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from slipscale.experiments.dataset import lineage
from slipscale.experiments.dataset.backup import KNOWN, backups
from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.files import draft_of, write_file
from slipscale.experiments.dataset.journals import journals
from slipscale.experiments.dataset.remains import LABEL, linked, remains
from slipscale.experiments.dataset.withdrawn import Pending, note, pending
from slipscale.experiments.journal.journal import FALLBACK
from slipscale.experiments.journal.locks import is_being_written
from slipscale.experiments.journal.plan_and_progress import read_usable
from slipscale.faults import UserError
from slipscale.faults.suggestions import expected_one_of


def theirs(dataset: Path, participant: str) -> list[Path]:
    """Return all files and folders with a participant's data or results computed from the data.

    Raises
    ------
    UserError
        If the data set has no such participant, if a session of the participant is running, or if a
        backup or merged set is not available.
    """
    return list(_found(dataset, participant, _todo(dataset, participant)))


def sources_with(dataset: Path, participant: str) -> list[Path]:
    """Return the sources of a merged set that contain the participant or cannot be accessed."""
    return [
        source
        for source in lineage.sources(dataset)
        if not source.is_dir() or any(_in_one(source, participant))
    ]


class Withdrawal(NamedTuple):
    """What a withdrawal did.

    Parameters
    ----------
    removed : list of Path
        Files and folders that were removed, or from which the participant was removed.
    left : list of Path
        Files and folders of other programs that may still hold data from the participant.
    """

    removed: list[Path]
    left: list[Path]


def withdraw(dataset: Path, participant: str) -> Withdrawal:
    """Remove a participant's data, record the withdrawal, and rebuild the data sets.

    Raises
    ------
    UserError
        If the data set has no such participant, if a session of the participant is running, if a
        backup or merged set is not available, or if a file or folder cannot be removed.
    """
    todo = _todo(dataset, participant)
    removed = list(_found(dataset, participant, todo))
    elsewhere = linked(removed)
    note(dataset, participant, todo)
    for copy in todo.merged:
        note(copy, participant, None)
    for path in todo.remove:
        _remove(path)
    for folder in (dataset, *todo.copies):
        built = (folder / "participants.tsv").exists()
        for path in list(_in_one(folder, participant)):
            if path.is_dir() or _is_of(path.name, participant):
                _remove(path)
            else:
                _strike(path, participant)
        if built or folder == dataset:
            build_dataset(folder, gone=[participant])
    note(dataset, participant, None)
    left = [path for path in elsewhere if path.exists()]
    left += [path for each in (dataset, *todo.copies) for path in remains(each, participant)]
    return Withdrawal(removed, left)


def _todo(dataset: Path, participant: str) -> Pending:
    """Return the recorded folders of a withdrawal; determine the folders if none are recorded."""
    _check_whole(dataset)
    todo = pending(dataset).get(participant)
    if todo is None:
        merged = _merged_sets(dataset)
        drafts = [draft_of(place) for place in merged if not place.exists()]
        drafts = [draft for draft in drafts if draft.is_dir()]  # remains of interrupted merges
        whole = [place for place in merged if draft_of(place) not in drafts]
        lists = {copy: each / KNOWN for each in (dataset, *whole) for copy in backups(each)}
        lists |= dict.fromkeys(whole, dataset / lineage.KNOWN)
        _check_there(lists)
        held = [copy for copy in lists if any(_in_one(copy, participant))]
        own = [path for each in (dataset, *held) for path in _journals_of(each, participant)]
        todo = Pending(
            remove=(*_kept_elsewhere(own), *drafts),
            copies=tuple(held),
            merged=tuple(place for place in whole if place in held),
        )
        if not any(_found(dataset, participant, todo)):
            raise _nothing_of(dataset, participant)
    else:
        _check_there(dict.fromkeys(todo.copies, dataset / KNOWN))
    for folder in (dataset, *todo.copies):
        if any(is_being_written(path) for path in _journals_of(folder, participant)):
            raise UserError(
                "--participant {participant}: a session of this participant is running; end it "
                "first",
                participant=participant,
            )
    return todo


def _check_whole(dataset: Path) -> None:
    """Raise `UserError` if the folder is a part of a data set, or contains data sets."""
    if journals(dataset) or not dataset.is_dir():
        return
    inside = [each for each in sorted(dataset.iterdir()) if each.is_dir()]
    near = [each for each in (*dataset.resolve().parents, *inside) if journals(each)]
    if near:
        raise UserError(
            "{dataset}: is not a data set; withdraw the participant from {near}",
            dataset=dataset,
            near=" or ".join(map(str, near)),
        )


def _nothing_of(dataset: Path, participant: str) -> UserError:
    labels = sorted({path.parent.name.removeprefix("sub-") for path in journals(dataset)})
    known = expected_one_of(participant, labels) if labels else "it contains no participants"
    return UserError(
        "--participant {participant}: {dataset} contains no data from this participant; {known}",
        participant=participant,
        dataset=dataset,
        known=known,
    )


def _merged_sets(dataset: Path) -> list[Path]:
    """Return the merged sets that include a data set, directly or through other merged sets."""
    found = [dataset]
    for place in found:
        found += [each for each in lineage.merged_into(place) if each not in found]
    return found[1:]


def _check_there(lists: dict[Path, Path]) -> None:
    for copy, file in lists.items():
        if not copy.is_dir():
            raise UserError(
                "the copy {copy} is not available, and may contain data from the participant: "
                "connect its disk; if it no longer exists, remove its line from {file}",
                copy=copy,
                file=file,
            )


def _found(dataset: Path, participant: str, todo: Pending) -> Iterator[Path]:
    yield from (path for path in todo.remove if path.exists())
    for folder in (*todo.copies, dataset):
        yield from _in_one(folder, participant)


def _in_one(folder: Path, participant: str) -> Iterator[Path]:
    """Yield a participant's folders in one data set, and the tables that list the participant.

    Programs that synchronise folders, and people, leave copies such as ``sub-01 (1)``. Everything
    whose name has the participant's label, and nobody else's, is the participant's.
    """
    results = folder / "derivatives/slipscale"
    here = list(_topmost(folder, participant, results))
    named = [path for path in _shared_tables(folder) if any(_lines_of(path, participant))]
    # Results are removed, because they do not show which participants are included.
    if named or here:
        yield from [results] if results.exists() else []
        yield from here
        yield from named


def _is_of(name: str, participant: str) -> bool:
    """Return whether a name has the participant's label and no other label."""
    return set(LABEL.findall(name)) == {participant}


def _topmost(folder: Path, participant: str, results: Path) -> Iterator[Path]:
    """Yield the participant's files and folders that are in no such folder."""
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        if _is_of(path.name, participant):
            yield path
        elif path.is_dir() and not path.is_symlink() and path != results:
            yield from _topmost(path, participant, results)


def _shared_tables(folder: Path) -> Iterator[Path]:
    """Yield the tables that list several participants, with temporary files and copies."""
    for place in ("participants*", "phenotype/*"):
        for pattern in (f"{place}.tsv", draft_of(Path(f"{place}.tsv")).as_posix()):
            yield from sorted(folder.glob(pattern))


def _lines_of(path: Path, participant: str) -> Iterator[int]:
    label = f"sub-{participant}".encode()
    for number, line in enumerate(path.read_bytes().splitlines()):
        if line.split(b"\t")[0].strip(b'" ') == label:
            yield number


def _strike(path: Path, participant: str) -> None:
    """Remove a participant's rows from a table, and delete the table if no other rows remain."""
    lines = path.read_bytes().splitlines(keepends=True)
    named = set(_lines_of(path, participant))
    left = [line for number, line in enumerate(lines) if number not in named]
    if len(left) > 1 and not path.name.endswith(".tmp"):
        write_file(path, b"".join(left), private=not path.stat().st_mode & 0o077)
        return
    with suppress(FileNotFoundError):
        path.with_suffix(".json").unlink()
    path.unlink()


def _remove(path: Path) -> None:
    with suppress(FileNotFoundError):
        try:
            shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
        except OSError as error:
            if not path.exists():
                return
            raise UserError(
                "{path}: cannot be removed ({reason}), so the withdrawal is not finished; allow it "
                "to be removed, and repeat the command",
                path=path,
                reason=error.strerror,
            ) from None


def _journals_of(dataset: Path, participant: str) -> list[Path]:
    return [path for path in journals(dataset) if path.parent.name == f"sub-{participant}"]


def _kept_elsewhere(own: list[Path]) -> Iterator[Path]:
    """Yield the fallback folders that contain the participant's journals from the same study."""
    studies = {plan.study_text for path in own if (plan := read_usable(path, most=1)[0])}
    if not own:
        return
    pattern = f"{FALLBACK}/*/sourcedata/{own[0].parent.name}/*_journal.jsonl"
    for parent in (Path.home(), Path(tempfile.gettempdir())):
        for path in sorted(parent.glob(pattern)):
            plan, _ = read_usable(path, most=1)
            if plan and plan.study_text in studies:
                yield path.parents[2]
