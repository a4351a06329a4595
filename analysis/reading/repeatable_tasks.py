"""Magnitude estimation and descending difference under labels of a study's own.

A study can hold either several times, each under a label. They are never taken together: one of
each is analysed, and what is not is told.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reading.labelled_tasks import header_of
from slipscale.analysis.reading.trial_tables import DIFFERENCE, ESTIMATION
from slipscale.faults import UserError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from slipscale.analysis.reading.delimited import Problems
    from slipscale.analysis.reading.labelled_tasks import Entries

#: A protocol's own label -> columns that its tables alone have, whatever their task is called.
KNOWN_BY = {
    ESTIMATION.task: {*ESTIMATION.required, "scale_top", "modulus"},
    DIFFERENCE.task: {*DIFFERENCE.required, "series", "step"},
}
WHAT = {ESTIMATION.task: "magnitude estimation", DIFFERENCE.task: "descending difference"}


def protocol_of(task: str, path: Path) -> str | None:
    """Return which of the two protocols wrote a task's table, by its own label; None: neither."""
    if task in KNOWN_BY:
        return task
    header = header_of(path)
    return next((own for own, columns in KNOWN_BY.items() if header.issuperset(columns)), None)


def of_one_task(
    tasks: Mapping[str, Mapping[str, Entries]],
    wanted: str | None,
    folder: Path,
    problems: Problems,
) -> dict[str, Entries]:
    """Return the tables of one task of each protocol, by the protocol's own label.

    Parameters
    ----------
    tasks : Mapping
        Protocol's own label -> task's label -> its tables.

    Raises
    ------
    UserError
        No such task is called as the wanted one.
    """
    labels = sorted(label for found in tasks.values() for label in found)
    if wanted is not None and wanted not in labels:
        raise UserError(
            f"--task {wanted}: {folder} holds no magnitude estimation or descending difference "
            f"of that label; expected {' or '.join(labels) or 'no --task'}"
        )
    chosen: dict[str, Entries] = {}
    for own, found in tasks.items():
        usual = own if own in found else min(found, default=own)
        label = wanted if wanted is not None and wanted in found else usual
        chosen[own] = found.get(label, [])
        if left := sorted(set(found) - {label}):
            problems.add(
                f"{WHAT[own]} was done under several labels: '{label}' is analysed, "
                f"{' and '.join(repr(each) for each in left)} left out; slipscale analyse --task "
                f"{left[0]} analyses that one"
            )
    return chosen
