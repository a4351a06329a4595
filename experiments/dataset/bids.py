"""The data set, written from its journals: rebuilt at will, never edited."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.experiments.dataset.files import write_file
from slipscale.experiments.dataset.former_tables import with_former
from slipscale.experiments.dataset.journals import Problem, read_runs
from slipscale.experiments.dataset.rendering import README
from slipscale.experiments.dataset.withdrawn import RECORD, unfinished

if TYPE_CHECKING:
    from collections.abc import Collection
    from pathlib import Path


def build_dataset(dataset: Path, gone: Collection[str] = ()) -> list[Problem]:
    """Write the data set that the journals under ``sourcedata`` give, and remove no row.

    Parameters
    ----------
    dataset : Path
        The data set's folder; its README.md is written once and is yours afterwards.
    gone : collection of str
        Labels of participants who are withdrawing: their rows are removed.

    Returns
    -------
    list of Problem
        What is damaged in the journals, and what only the tables hold; see
        `slipscale.experiments.dataset.former_tables`.

    Raises
    ------
    UserError
        It holds both pilots and participants, or cannot be written.
    """
    runs, problems = read_runs(dataset)
    files, kept = with_former(dataset, runs, gone)
    private = any(run.plan.study.private_files for run in runs)
    for name, content in files.items():
        path = dataset / name
        if name != README or not path.exists():
            write_file(path, content, private=private)
    waiting = [] if gone else unfinished(dataset)
    return [*problems, *kept, *(Problem(file=RECORD.as_posix(), what=each) for each in waiting)]
