"""Write a data set from its journals, from which all tables can be rebuilt at any time."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from slipscale.experiments.dataset.files import missing_lines, write_file
from slipscale.experiments.dataset.former_tables import with_former
from slipscale.experiments.dataset.journals import Problem, read_runs
from slipscale.experiments.dataset.rendering import GIT_ATTRIBUTES, README
from slipscale.experiments.dataset.withdrawn import RECORD, unfinished


def build_dataset(dataset: Path, gone: Collection[str] = ()) -> list[Problem]:
    """Write a data set from the journals in ``sourcedata``, and keep all existing rows.

    Parameters
    ----------
    dataset : Path
        Folder of the data set. An existing README.md is not overwritten, and in
        .gitattributes, where DataLad has its own lines, only missing lines are added.
    gone : collection of str
        Labels of participants who are being withdrawn, whose rows are removed.

    Returns
    -------
    list of Problem
        Damage in the journals, and data that only the tables contain (see
        `slipscale.experiments.dataset.former_tables`).

    Raises
    ------
    UserError
        If the data set contains both pilots and participants, or if a file cannot be written.
    """
    runs, problems = read_runs(dataset)
    files, kept = with_former(dataset, runs, gone)
    private = any(run.plan.study.private_files for run in runs)
    for name, content in files.items():
        path = dataset / name
        if name == GIT_ATTRIBUTES and (lacking := missing_lines(path, str(content))):
            before = path.read_bytes() if path.exists() else b""
            before += b"\n" if before and not before.endswith(b"\n") else b""
            write_file(path, before + lacking, private=private)
        elif name not in (README, GIT_ATTRIBUTES) or not path.exists():
            write_file(path, content, private=private)
    waiting = [] if gone else unfinished(dataset)
    return [*problems, *kept, *(Problem(file=RECORD.as_posix(), what=each) for each in waiting)]
