"""Refuse the tables that Slipscale's own analysis wrote, and name the data to use instead.

Result tables lack practice trials, study choices and other tasks, so that their analysis could give
other results. Copies of tables in other folders are recognised by their columns. A copy of
``estimates.csv`` can be analysed, because the table contains the scale top, the modulus and the
normalisation rule.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from slipscale.faults import UserError

#: File of the results folder that lists the tables and the files from which they were computed.
RESULTS = "results.json"
#: Table of results -> columns by which a copy is recognised, without those that contain a unit.
#: ``log_*`` is any column that begins with log_.
COLUMNS: dict[str, frozenset[str]] = {
    name: frozenset(columns.split())
    for name, columns in {
        "textures.csv": "texture n mean",
        "table3.csv": "n mean maximum_deviation standard_deviation",
        "descriptives.csv": "n mean sd_sample geometric_mean",
        "pairwise.csv": "ratio_ci_low d_z p_wilcoxon",
        "individuals.csv": "participant_id exponent points",
        "quality.csv": "participant_id non_monotone constant drift",
        "difference.csv": "n yes ci95_low ci95_high",
        "answers.csv": "participant_id series step catch difference_felt",
        "thresholds.csv": "task trials correct catch_trials catch_correct",
        "matching.csv": "task matches participants felt_again",
        "pointing.csv": "task movements error_share throughput_bit_s",
        "scales.csv": "task model surface value",
        "wide.csv": "participant_id estimate_* log_*",
    }.items()
}


class OwnResults(UserError):
    """Exception raised for tables that an analysis wrote."""


def refuse_copy(names: Sequence[str], path: Path) -> None:
    """Raise `OwnResults` if columns are those of a table that an analysis wrote."""
    found = {*names, *(f"{name.partition('_')[0]}_*" for name in names)}
    for table, columns in COLUMNS.items():
        if columns <= found:
            raise OwnResults(
                "{path}: has the columns of {table}, which contains results of slipscale analyse; "
                "expected the data set from which they were computed, or a copy of its "
                "estimates.csv",
                path=path,
                table=table,
            )


def refuse_results(path: Path) -> None:
    """Raise `OwnResults` if the path is a results folder, or a table that an analysis wrote there.

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
    raise OwnResults(
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
