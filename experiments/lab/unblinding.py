"""When results may be seen before the end: an act that is written down.

Answers as they come in unblind the operator who sees them. Means and figures are shown once all
planned participants are done, or after somebody has said, and it was recorded, that they want to
see them before.
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
    """Return when somebody asked to see results before the end, in UTC.

    Raises
    ------
    UserError
        The record cannot be read.
    """
    path = dataset / RECORD
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
        return [str(entry["unblinded_utc"]) for entry in entries]
    except (FileNotFoundError, NotADirectoryError):
        return []
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise UserError(f"{path}: cannot be read ({error})") from None


def unblind(dataset: Path, roster: Roster) -> None:
    """Write down that results are looked at from now on, and how many had taken part."""
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
