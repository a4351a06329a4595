"""Maintain a data set's list of withdrawn participants and unfinished withdrawals.

A participant's entry is marked as pending before the first file is removed. The mark is deleted
when the withdrawal is finished.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from slipscale.experiments.dataset.files import write_file
from slipscale.faults import UserError
from slipscale.faults.message import Message

RECORD = Path("sourcedata", "withdrawn.json")
PENDING = "pending"


@dataclass(frozen=True, slots=True, kw_only=True)
class Pending:
    """Folders outside a data set from which a withdrawn participant must still be removed.

    Parameters
    ----------
    remove : tuple of Path
        Folders to be removed completely: fallback folders with journals, and unfinished merges.
    copies : tuple of Path
        Backups and merged data sets that contain data from the participant.
    merged : tuple of Path
        The ``copies`` that are merged data sets, which have their own lists of withdrawals.
    """

    remove: tuple[Path, ...] = ()
    copies: tuple[Path, ...] = ()
    merged: tuple[Path, ...] = ()


def withdrawn(dataset: Path) -> list[str]:
    """Return the labels of withdrawn participants in the order of the list."""
    return [str(entry["participant"]) for entry in entries(dataset)]


def pending(dataset: Path) -> dict[str, Pending]:
    """Return the unfinished withdrawals of a data set, by label."""
    return {
        str(entry["participant"]): Pending(
            **{name: tuple(map(Path, paths)) for name, paths in entry[PENDING].items()}
        )
        for entry in entries(dataset)
        if PENDING in entry
    }


def unfinished(dataset: Path) -> Iterator[str]:
    """Yield a sentence for each unfinished withdrawal, which explains how to finish it."""
    for label in pending(dataset):
        yield (
            Message(
                "the withdrawal of participant {label} is not finished; to finish it, run "
                "slipscale data withdraw {dataset} --participant {label} --yes",
                label=label,
                dataset=dataset,
            )
        )


def note(dataset: Path, participant: str, todo: Pending | None) -> None:
    """Record the folders of an unfinished withdrawal; None marks the withdrawal as finished."""
    known = {str(entry["participant"]): entry for entry in entries(dataset)}
    day = datetime.now(UTC).date().isoformat()
    entry = known.setdefault(participant, {"participant": participant, "withdrawn_utc": day})
    entry.pop(PENDING, None)
    if todo is not None:
        entry[PENDING] = {
            name: [str(path) for path in getattr(todo, name)] for name in Pending.__slots__
        }
    text = json.dumps(list(known.values()), indent=2) + "\n"
    write_file(dataset / RECORD, text, durable=True)


def entries(dataset: Path) -> list[dict[str, Any]]:
    """Return the entries of the list of withdrawals.

    Raises
    ------
    UserError
        If the list cannot be read.
    """
    try:
        found = json.loads((dataset / RECORD).read_text(encoding="utf-8"))
        for entry in found:
            entry["participant"], dict(entry.get(PENDING, {}))
    except (FileNotFoundError, NotADirectoryError):
        return []
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        raise UserError(
            "{dataset}: cannot be read ({error}); expected the list written by slipscale data "
            "withdraw",
            dataset=dataset / RECORD,
            error=error,
        ) from None
    return list(found)


def replacement(participant: str) -> str:
    """Return the label of a withdrawn participant's replacement.

    >>> replacement("03"), replacement("R03")
    ('R03', 'RR03')
    """
    return f"R{participant}"
