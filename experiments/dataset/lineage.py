"""Record which data sets were merged, and which merged sets include a data set.

The sources and the merged set refer to each other, because a participant's withdrawal affects all
of these data sets.
"""

from __future__ import annotations

import json
from pathlib import Path

from slipscale.experiments.dataset.files import write_file
from slipscale.faults import UserError

KNOWN = Path("sourcedata", "merged.json")
SOURCES, INTO = "sources", "merged_into"


def sources(dataset: Path) -> list[Path]:
    """Return the sources of a merged data set; empty for other data sets."""
    return _read(dataset)[SOURCES]


def merged_into(dataset: Path) -> list[Path]:
    """Return the merged data sets that include this data set."""
    return _read(dataset)[INTO]


def note_source(dataset: Path, source: Path) -> None:
    """Record in a merged data set that ``source`` is one of its sources."""
    _add(dataset, SOURCES, source)


def note_merged(dataset: Path, merged: Path) -> None:
    """Record in a data set that it is included in a merged data set."""
    _add(dataset, INTO, merged)


def _add(dataset: Path, name: str, place: Path) -> None:
    known = _read(dataset)
    if place.resolve() not in known[name]:
        known[name].append(place.resolve())
        lists = {key: [str(path) for path in paths] for key, paths in known.items()}
        write_file(dataset / KNOWN, lists)


def _read(dataset: Path) -> dict[str, list[Path]]:
    """Read the list of sources and the list of merged sets of a data set.

    Raises
    ------
    UserError
        If the lists cannot be read.
    """
    path = dataset / KNOWN
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return {name: [Path(str(each)) for each in content[name]] for name in (SOURCES, INTO)}
    except (FileNotFoundError, NotADirectoryError):
        return {SOURCES: [], INTO: []}
    except (OSError, ValueError, LookupError, TypeError, RecursionError) as error:
        raise UserError(
            "{path}: cannot be read ({error}); expected the lists written by slipscale data merge",
            path=path,
            error=error,
        ) from None
