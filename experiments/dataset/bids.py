"""The data set, written from its journals: rebuilt at will, never edited."""

from __future__ import annotations

import json
import os
from contextlib import suppress
from typing import TYPE_CHECKING

from slipscale.experiments.dataset.journals import read_runs
from slipscale.experiments.dataset.rendering import README, render
from slipscale.experiments.dataset.verification import cut_journals
from slipscale.experiments.journal.journal import AS_USUAL, OWNER_ONLY
from slipscale.faults import UserError

if TYPE_CHECKING:
    from pathlib import Path

    from slipscale.experiments.dataset.journals import Problem
    from slipscale.experiments.dataset.rendering import Content


def write_file(path: Path, content: Content, *, private: bool = False) -> None:
    """Write a file whole or not at all, for its owner alone if it is private.

    Raises
    ------
    UserError
        It cannot be written.
    """
    text = content if isinstance(content, str) else json.dumps(content, indent=2) + "\n"
    draft = path.with_name(f".{path.name}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        draft.touch(OWNER_ONLY if private else AS_USUAL)
        draft.write_text(text, encoding="utf-8", newline="\n")
        os.replace(draft, path)  # noqa: PTH105 - Path.replace is the same call
    except OSError as error:
        with suppress(OSError):
            draft.unlink()
        raise UserError(f"{path}: cannot be written ({error.strerror})") from None


def build_dataset(dataset: Path) -> list[Problem]:
    """Write the data set that the journals under ``sourcedata`` give.

    Parameters
    ----------
    dataset : Path
        The data set's folder; its README.md is written once and is yours afterwards.

    Returns
    -------
    list of Problem
        What is damaged of the journals; all other runs are written. The tables of a journal that
        has lost its end since they were made stay as they are: they are all that is left of it.

    Raises
    ------
    UserError
        It holds both pilots and participants, or cannot be written.
    """
    runs, problems = read_runs(dataset)
    cut = cut_journals(dataset, runs)
    files, unfit = render(runs)
    private = any(run.plan.study.private_files for run in runs)
    kept = {table for tables in cut.values() for table in tables}
    for name, content in files.items():
        path = dataset / name
        if name in kept or (name == README and path.exists()):
            continue
        write_file(path, content, private=private)
    return [*problems, *unfit, *cut]
