"""Read the columns that a mapping names, from a table or from the tables in a BIDS folder."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from slipscale.analysis.reading.cells import listed
from slipscale.analysis.reading.delimited import Problems, Source, read_tables
from slipscale.analysis.reading.foreign.columns import NUMBERS, OURS
from slipscale.analysis.reading.labelled_tasks import header_of
from slipscale.analysis.reading.programs.records import as_text
from slipscale.analysis.reading.table_by_hand import read_table
from slipscale.faults import UserError
from slipscale.faults.folders import visible

if TYPE_CHECKING:
    from slipscale.analysis.reading.mapping import TableMapping

#: Names of tables in a folder, and the parts of these names that are used.
BIDS_TABLE = re.compile(r"sub-[^_]+(_[^_]+)*_(beh|events)\.tsv")
BIDS_LABEL = re.compile(r"(?<![^_])(sub|ses|task|run)-([^_]+)")
#: Label in file names, keyed by the field of `mapping.Columns` with the same meaning.
IN_NAMES = {"participant": "sub", "session": "ses", "run": "run"}


def read_rows(
    path: Path, mapping: TableMapping, problems: Problems, task: str | None
) -> tuple[pd.DataFrame, list[Source]]:
    """Read the rows that ``only`` selects; return them with the columns in the mapping.

    The session and the run are also returned if they are in the names of a folder's files.
    """
    columns = mapping.columns.model_dump(exclude_none=True)
    kept = [*columns.values(), *mapping.levels, "file", "line"]
    if path.is_dir():
        unnamed = {name: OURS[name] for name in IN_NAMES if OURS[name] not in kept}
        columns = unnamed | columns
        kept += unnamed.values()
        frame, sources = _folder(path, columns, mapping, problems, task)
    else:
        frame, sources = _table(path, columns, mapping, problems)
    # A column that is only needed to select rows could have the name of one of Slipscale's columns.
    return chosen(frame, mapping.table.only, path)[[c for c in frame if c in kept]], sources


def _table(
    path: Path, columns: Mapping[str, str], mapping: TableMapping, problems: Problems
) -> tuple[pd.DataFrame, list[Source]]:
    figures = [columns[name] for name in NUMBERS if name in columns] + list(mapping.levels)
    words = [column for name, column in columns.items() if name not in NUMBERS]
    words += [column for column in mapping.table.only if column not in (*words, *figures)]
    frame, source = read_table(
        path,
        required=(*words, *figures),
        numbers=figures,
        words=words,
        identifier=mapping.columns.participant,
        problems=problems,
        decimal=mapping.table.decimal,
        sheet=mapping.table.sheet,
    )
    return frame, [source]


def _folder(
    folder: Path,
    columns: Mapping[str, str],
    mapping: TableMapping,
    problems: Problems,
    task: str | None,
) -> tuple[pd.DataFrame, list[Source]]:
    """Read one task's tables in a BIDS folder, with participant, session and run from their names.

    A label is not taken from the names if the mapping names a different column for it.
    """
    from_names = {
        columns[name]: label
        for name, label in IN_NAMES.items()
        if columns.get(name) in (OURS[name], label)
    }
    needed = [c for c in (*columns.values(), *mapping.levels) if c not in from_names]
    needed += [c for c in mapping.table.only if c not in (*needed, *from_names)]
    paths = _of_task(folder, task)
    paths = _one_per_run(paths, frozenset(needed), problems)
    frame, sources = read_tables(
        paths, folder, required=needed, columns=needed, problems=problems, foreign=True
    )
    of_files = [dict(BIDS_LABEL.findall(path.stem)) for path in paths]
    for column, label in from_names.items():
        prefix = f"{label}-" if label == "sub" else ""
        found = pd.Series([prefix + of_file.get(label, "") for of_file in of_files], dtype="str")
        frame[column] = found.iloc[frame["file"].to_numpy()].to_numpy()
    for name in ("group", "answer", "block"):
        if name in columns:
            frame[columns[name]] = frame[columns[name]].astype("str")
    return frame, sources


def _of_task(folder: Path, task: str | None) -> list[Path]:
    """Return the tables of a task.

    Raises
    ------
    UserError
        If there are no tables, the task does not exist, or a task must be selected.
    """
    tasks: dict[str, list[Path]] = {}
    for path in visible(folder, "sub-*/**/*.tsv"):
        if BIDS_TABLE.fullmatch(path.name):
            label = dict(BIDS_LABEL.findall(path.stem)).get("task", "")
            tasks.setdefault(label, []).append(path)
    if not tasks:
        raise UserError(
            "{folder}: no data found; expected files like "
            "sub-01/beh/sub-01_task-loudness_beh.tsv or ..._events.tsv",
            folder=folder,
        )
    labels = listed(sorted(filter(None, tasks))) or "none with a label"
    if task is None and len(tasks) > 1:
        raise UserError(
            "{folder}: contains several tasks: {labels}; expected the label of the task to "
            "analyse (--task)",
            folder=folder,
            labels=labels,
        )
    if task is not None and task not in tasks:
        raise UserError(
            "--task {task}: {folder} contains the tasks {labels}; expected one label",
            task=task,
            folder=folder,
            labels=labels,
        )
    return next(iter(tasks.values())) if task is None else tasks[task]


def _one_per_run(paths: list[Path], needed: frozenset[str], problems: Problems) -> list[Path]:
    """Return one table per run: the first with all columns, ``_beh`` before ``_events``."""
    runs: dict[str, list[Path]] = {}
    for path in paths:
        runs.setdefault(path.stem.rpartition("_")[0], []).append(path)
    kept = [
        min(run, key=lambda path: (not needed <= header_of(path, foreign=True), path.name))
        for run in runs.values()
    ]
    if more := len(paths) - len(kept):
        problems.add(
            f"{more} runs have two tables, _beh and _events; only one of them is read: the table "
            "with the named columns or, if both have them, _beh"
        )
    return kept


def chosen(frame: pd.DataFrame, only: Mapping[str, Sequence[str]], path: Path) -> pd.DataFrame:
    """Select the rows that have one of the given values in each column.

    Raises
    ------
    UserError
        If a value does not occur.
    """
    for column, values in only.items():
        cells = frame[column]
        found = (cells if cells.dtype == "str" else cells.map(as_text)).astype("str").str.strip()
        wanted = [value.strip() for value in values]
        if absent := [value for value in wanted if not (found == value).any()]:
            known = ", ".join(sorted(found.dropna().unique())[:12]) or "nothing"
            raise UserError(
                "{path}: no row has '{missing}' in column {column}; found {known}",
                path=path,
                missing=absent[0],
                column=column,
                known=known,
            )
        frame = frame[found.isin(wanted)].reset_index(drop=True)
    return frame
