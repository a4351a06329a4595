"""A participant withdraws: all that is theirs goes, and a record that somebody withdrew stays.

Their number is never used again. Whoever replaces them has the label R and their number: the
place in the counterbalancing follows from the number that a label ends with.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.experiments.dataset.backup import KNOWN, backups
from slipscale.experiments.dataset.bids import build_dataset, write_file
from slipscale.experiments.dataset.journals import journals, read_runs
from slipscale.experiments.dataset.phenotype import phenotype
from slipscale.experiments.journal.journal import FALLBACK
from slipscale.experiments.journal.locks import is_being_written
from slipscale.experiments.journal.plan_and_progress import read_usable
from slipscale.faults import UserError
from slipscale.faults.suggestions import expected_one_of

if TYPE_CHECKING:
    from collections.abc import Iterator

RECORD = Path("sourcedata", "withdrawn.json")


def withdrawn(dataset: Path) -> list[str]:
    """Return the labels of those who withdrew, in order."""
    try:
        entries = json.loads((dataset / RECORD).read_text(encoding="utf-8"))
        return [str(entry["participant"]) for entry in entries]
    except (FileNotFoundError, NotADirectoryError):
        return []
    except (OSError, ValueError, LookupError, TypeError, RecursionError) as error:
        raise UserError(
            f"{dataset / RECORD}: cannot be read ({error}); expected the list that slipscale data "
            "withdraw writes"
        ) from None


def replacement(participant: str) -> str:
    """Return the label of who takes the place of a participant who withdrew.

    >>> replacement("03"), replacement("R03")
    ('R03', 'RR03')
    """
    return f"R{participant}"


def theirs(dataset: Path, participant: str) -> list[Path]:
    """Return all files and folders that hold something of a participant, their journals last.

    The journals tell where else to look: a withdrawal that was broken off finds the rest by them.
    What was derived from all participants holds them too. Journals that were written in a fallback
    folder are looked for by their label and study; in backups, by their label.

    Raises
    ------
    UserError
        The data set has no such participant, one of their sessions runs now, or a backup is not
        there.
    """
    own = [path for path in journals(dataset) if path.parent.name == f"sub-{participant}"]
    here = [path for path in _places(dataset, participant) if path.exists()]
    if not own and dataset / f"sub-{participant}" not in here and not _begun(dataset, participant):
        labels = sorted({path.parent.name.removeprefix("sub-") for path in journals(dataset)})
        known = expected_one_of(participant, labels) if labels else "it holds no participants"
        raise UserError(f"--participant {participant}: {dataset} holds nothing of them; {known}")
    if any(is_being_written(path) for path in own):
        raise UserError(f"--participant {participant}: a session of theirs runs now; end it first")
    return [*_kept_elsewhere(own), *_backed_up(dataset, participant), *here]


def _places(dataset: Path, participant: str) -> tuple[Path, ...]:
    return (
        dataset / "derivatives" / "slipscale",
        dataset / f"sub-{participant}",
        dataset / "sourcedata" / f"sub-{participant}",
    )


def _begun(dataset: Path, participant: str) -> bool:
    """Return whether a withdrawal was noted, and broken off before the tables were made anew."""
    people = dataset / "participants.tsv"
    noted = participant in withdrawn(dataset) and people.is_file()
    return noted and f"sub-{participant}\t" in people.read_text(encoding="utf-8", errors="replace")


def _backed_up(dataset: Path, participant: str) -> Iterator[Path]:
    """Yield what the data set's backups hold of a participant: journals, tables, results.

    Raises
    ------
    UserError
        A backup is not there: what it holds would stay.
    """
    for backup in backups(dataset):
        if not backup.is_dir():
            raise UserError(
                f"the backup {backup} is not there, and holds data of the participant: connect its "
                f"disk; if it is gone for good, take its line out of {dataset / KNOWN}"
            )
        yield from (place for place in _places(backup, participant) if place.exists())


def _kept_elsewhere(own: list[Path]) -> Iterator[Path]:
    """Yield the fallback folders that hold a participant's journal of the same study."""
    studies = {plan.study_text for path in own if (plan := read_usable(path, most=1)[0])}
    if not own:
        return
    pattern = f"{FALLBACK}/*/sourcedata/{own[0].parent.name}/*_journal.jsonl"
    for parent in (Path.home(), Path(tempfile.gettempdir())):
        for path in sorted(parent.glob(pattern)):
            plan, _ = read_usable(path, most=1)
            if plan and plan.study_text in studies:
                yield path.parents[2]


def withdraw(dataset: Path, participant: str) -> list[Path]:
    """Remove a participant, note that they withdrew, and build the data set anew.

    Returns
    -------
    list of Path
        What was removed.
    """
    gone = theirs(dataset, participant)
    known = withdrawn(dataset)  # raises where the list cannot be read
    tables = set(_of_questionnaires(dataset))
    entries = json.loads((dataset / RECORD).read_text(encoding="utf-8")) if known else []
    day = datetime.now(UTC).date().isoformat()
    if participant not in known:
        entries.append({"participant": participant, "withdrawn_utc": day})
    # First the note: a crash in between must not have the number offered again.
    write_file(dataset / RECORD, json.dumps(entries, indent=2) + "\n")
    for path in gone:
        try:
            shutil.rmtree(path)
        except OSError as error:
            raise UserError(f"{path}: cannot be removed ({error.strerror})") from None
    for folder in (dataset, *(each for each in backups(dataset) if _is_built(each))):
        runs, _ = read_runs(folder)
        for name in tables:  # made anew from those who stay; a laboratory's own tables are let be
            (folder / name).unlink(missing_ok=True)
        if not runs:
            for name in ("participants.tsv", "participants.json"):
                (folder / name).unlink(missing_ok=True)
        build_dataset(folder)
    return gone


def _of_questionnaires(dataset: Path) -> Iterator[str]:
    """Yield the names of the tables that the data set's questionnaires fill."""
    runs, _ = read_runs(dataset)
    for name, _ in phenotype(runs):
        yield str(name)


def _is_built(backup: Path) -> bool:
    """Return whether somebody had a backup's tables made, which list all participants."""
    return (backup / "participants.tsv").exists()
