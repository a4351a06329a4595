"""Magnitude estimation and descending difference under labels of a study's own.

A study can hold either several times, each under a label. They are never taken together: one of
each is analysed, and what is not is told.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from analysis.reading.labelled_tasks import header_of
from analysis.reading.trial_tables import DIFFERENCE, ESTIMATION
from faults import UserError

if TYPE_CHECKING:
    import re
    from pathlib import Path

    from analysis.reading.delimited import Problems
    from analysis.reading.labelled_tasks import Entries

#: A protocol's own label -> columns that its tables alone have, whatever their task is called.
KNOWN_BY = {
    ESTIMATION.task: {*ESTIMATION.required, "scale_top", "modulus"},
    DIFFERENCE.task: {*DIFFERENCE.required, "series", "step"},
}
WHAT = {ESTIMATION.task: "magnitude estimation", DIFFERENCE.task: "descending difference"}


def is_repeatable(task: str, path: Path) -> bool:
    """Return whether a task's table is one of magnitude estimation or descending difference."""
    return task in KNOWN_BY or any(map(header_of(path).issuperset, KNOWN_BY.values()))


def of_one_task(
    entries: Entries, wanted: str | None, folder: Path, problems: Problems
) -> dict[str, list[tuple[Path, re.Match[str]]]]:
    """Return the tables of one task of each protocol, by the protocol's own label.

    Raises
    ------
    UserError
        No such task is called as the wanted one.
    """
    tasks: dict[str, dict[str, list[tuple[Path, re.Match[str]]]]] = {own: {} for own in KNOWN_BY}
    for path, match in entries:
        label = match["task"]
        own = label if label in KNOWN_BY else _protocol(path)
        tasks[own].setdefault(label, []).append((path, match))
    labels = sorted(label for found in tasks.values() for label in found)
    if wanted is not None and wanted not in labels:
        raise UserError(
            f"--task {wanted}: {folder} holds no magnitude estimation or descending difference "
            f"of that label; expected {' or '.join(labels) or 'no --task'}"
        )
    chosen = {}
    for own, found in tasks.items():
        label = wanted if wanted in found else own if own in found else min(found, default=own)
        chosen[own] = found.get(label, [])
        if left := sorted(set(found) - {label}):
            problems.add(
                f"{WHAT[own]} was done under several labels: '{label}' is analysed, "
                f"{' and '.join(repr(each) for each in left)} left out; slipscale analyse --task "
                f"{left[0]} analyses that one"
            )
    return chosen


def _protocol(path: Path) -> str:
    header = header_of(path)
    return next(own for own, columns in KNOWN_BY.items() if header.issuperset(columns))
