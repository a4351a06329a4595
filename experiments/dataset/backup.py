"""After a run, copy the run's journal to a backup folder and verify the copy.

A backup has the structure of a data set, so ``slipscale data build`` can write its tables. The data
set lists its backups, because a withdrawal must also remove data from each backup.
"""

from __future__ import annotations

import json
import os
import shutil
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

from slipscale.experiments.dataset.files import write_file
from slipscale.experiments.dataset.hand_exclusions import RECORD
from slipscale.experiments.dataset.journals import journals
from slipscale.faults import UserError

KNOWN = Path("sourcedata", "backups.json")


def back_up(dataset: Path, journal: Path, folder: Path) -> Path:
    """Copy a journal to a backup folder, verify the copy and return its path.

    Decisions to exclude the participant are also copied.

    Parameters
    ----------
    dataset : Path
        The data set, after which its backup in ``folder`` is named.
    journal : Path
        The journal of a finished run.
    folder : Path
        Backup folder outside the data set. A missing folder is not created, because a disconnected
        disk would otherwise be mistaken for an empty folder.

    Raises
    ------
    UserError
        If the folder is missing, is inside the data set, or contains a different run under the same
        name, or if the copy cannot be written or differs from the journal.
    """
    check_folder(dataset, folder)
    place = folder.resolve() / dataset.resolve().name
    copy = place / "sourcedata" / journal.parent.name / journal.name
    draft = copy.with_name(f".{copy.name}.tmp")
    try:
        content = journal.read_bytes()
        # A journal only grows, so an earlier copy must match the beginning of the journal.
        if copy.exists() and not content.startswith(copy.read_bytes()):
            raise UserError(
                "{copy}: contains another run, or a longer journal of this run; expected a "
                "separate backup folder for this data set",
                copy=copy,
            )
        copy.parent.mkdir(parents=True, exist_ok=True)
        _remember(dataset, place)
        with draft.open("wb") as stream:
            shutil.copymode(journal, draft)
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(draft, copy)  # noqa: PTH105 - Path.replace is the same call
        same = sha256(copy.read_bytes()).digest() == sha256(content).digest()
    except OSError as error:
        with suppress(OSError):
            draft.unlink()
        raise UserError(
            "{copy}: cannot be written ({reason})", copy=copy, reason=error.strerror
        ) from None
    if not same:
        raise UserError(
            "{copy}: the copy differs from the journal; the medium may be faulty", copy=copy
        )
    if (decided := journal.with_name(RECORD)).is_file():
        write_file(copy.with_name(RECORD), decided.read_bytes(), durable=True)
    return copy


def back_up_exclusions(dataset: Path, participant: str) -> None:
    """Copy the decisions to exclude a participant to every backup that contains the participant.

    If a backup is not connected, the decisions are copied after the participant's next run.
    """
    decided = dataset / "sourcedata" / f"sub-{participant}" / RECORD
    for place in backups(dataset):
        copy = place / decided.relative_to(dataset)
        if copy.parent.is_dir():
            write_file(copy, decided.read_bytes(), durable=True)


def check_folder(dataset: Path, folder: Path) -> None:
    """Raise `UserError` unless a folder is suitable for backups of a data set."""
    if not folder.is_dir():
        raise UserError(
            "--backup {folder}: no such folder; connect its disk, or create it", folder=folder
        )
    if folder.resolve().is_relative_to(dataset.resolve()):
        raise UserError(
            "--backup {folder}: the folder is inside the data set; expected a folder elsewhere",
            folder=folder,
        )
    if folder.resolve() == dataset.resolve().parent:
        raise UserError(
            "--backup {folder}: the folder contains the data set itself; expected a folder "
            "elsewhere",
            folder=folder,
        )


def why_no_backup(dataset: Path, folder: Path) -> str:
    """Return the reason why a folder cannot be used for backups; empty if it can be used."""
    try:
        check_folder(dataset, folder)
    except UserError as fault:
        return str(fault)
    return ""


def not_backed_up(dataset: Path, folder: Path | None) -> list[Path]:
    """Return the journals that have no copy of equal length in any connected backup.

    Parameters
    ----------
    folder : Path, optional
        A backup folder to be checked in addition to the folders that the data set lists.
    """
    places = [*backups(dataset), *([folder / dataset.resolve().name] if folder else [])]

    def copied(journal: Path) -> bool:
        copies = (place / journal.relative_to(dataset) for place in places)
        size = journal.stat().st_size
        return any(copy.is_file() and copy.stat().st_size == size for copy in copies)

    return [journal for journal in journals(dataset) if not copied(journal)]


def backups(dataset: Path) -> list[Path]:
    """Return the backup folders that a data set lists.

    Raises
    ------
    UserError
        If the list cannot be read.
    """
    path = dataset / KNOWN
    try:
        return [Path(str(entry)) for entry in json.loads(path.read_text(encoding="utf-8"))]
    except (FileNotFoundError, NotADirectoryError):
        return []
    except (OSError, ValueError, TypeError, RecursionError) as error:
        raise UserError(
            "{path}: cannot be read ({error}); expected the list that --backup writes",
            path=path,
            error=error,
        ) from None


def _remember(dataset: Path, place: Path) -> None:
    """Add a backup to the data set's list of backups, before anything is written to it."""
    known = backups(dataset)
    if place not in known:
        write_file(dataset / KNOWN, json.dumps([str(each) for each in [*known, place]]) + "\n")
