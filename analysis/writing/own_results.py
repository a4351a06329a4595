"""Refuse the tables that Slipscale's own analysis wrote, and name the data to use instead.

Result tables lack practice trials, study choices and other tasks, so that their analysis could give
other results. A copy of ``estimates.csv`` outside its folder can be analysed, because the table
contains the scale top, the modulus and the normalisation rule.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from slipscale.faults import UserError

#: File of the results folder that lists the tables and the files from which they were computed.
RESULTS = "results.json"


def refuse_results(path: Path) -> None:
    """Raise `UserError` if the path is a results folder, or a table that an analysis wrote there.

    Tables of the user may be in the same folder.
    """
    folder = path if path.is_dir() else path.parent
    results = _results(folder)
    tables, sources = _texts(results.get("tables")), _texts(results.get("files"))
    if not (tables and sources):
        return
    # Results may be in the folder that contains the data.
    if not (path.name in tables or (path.is_dir() and not (path / sources[0]).exists())):
        return
    places = (where := folder.resolve(), *where.parents[:2])
    near = [each for each in places if (each / sources[0]).exists()]
    place = near[0] if near else Path()
    raise UserError(
        "{path}: contains results of slipscale analyse; expected the data from which they were "
        "computed: slipscale analyse {source}",
        path=path,
        source=place if near and len(sources) > 1 else place / sources[0],
    )


def _results(folder: Path) -> Mapping[str, object]:
    try:
        found = json.loads((folder / RESULTS).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _texts(found: object) -> list[str]:
    return [str(each) for each in found] if isinstance(found, list | dict) else []
