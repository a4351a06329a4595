"""Decide whether results may be shown, and record early unblinding.

An operator who sees answers while data are being collected is no longer blind. Means and figures
are therefore shown only when all planned participants are done, or when an operator requests them,
which is recorded.
"""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.experiments.dataset.files import write_file
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.experiments.lab.roster import Roster

RECORD = Path("sourcedata", "unblinded.json")


def unblinded(dataset: Path) -> list[str]:
    """Return the times (UTC) at which results were requested before the planned end.

    Raises
    ------
    UserError
        If the record cannot be read.
    """
    path = dataset / RECORD
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
        return [str(entry["unblinded_utc"]) for entry in entries]
    except (FileNotFoundError, NotADirectoryError):
        return []
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise UserError("{path}: cannot be read ({error})", path=path, error=error) from None


def unblind(dataset: Path, roster: Roster) -> None:
    """Record that results were requested early, and the number of participants so far."""
    path = dataset / RECORD
    entries = json.loads(path.read_text(encoding="utf-8")) if unblinded(dataset) else []
    entries.append(
        {
            "unblinded_utc": datetime.now(UTC).isoformat(timespec="seconds"),
            "done": len(roster.of("done")),
            "planned": roster.planned,
        }
    )
    write_file(path, json.dumps(entries, indent=2) + "\n")


def results_may_be_seen(dataset: Path, roster: Roster) -> bool:
    """Return whether means and figures may be shown."""
    return len(roster.of("done")) >= roster.planned or bool(unblinded(dataset))
