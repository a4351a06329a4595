"""Read the columns that a mapping names, from one or several tables or from a BIDS folder.

Tables with the same columns are read as one table. A table that cannot be read is named and left
out, unless it is the only one.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from slipscale.analysis.reading.cells import listed
from slipscale.analysis.reading.delimited import STANDARD_INPUT, Problems, Source, header_of
from slipscale.analysis.reading.foreign.columns import NUMBERS, OURS
from slipscale.analysis.reading.foreign.names import people_in_names
from slipscale.analysis.reading.foreign.together import read_together
from slipscale.analysis.reading.own_results import RESULTS
from slipscale.analysis.reading.programs.records import as_text
from slipscale.analysis.reading.suspicions import check_labels
from slipscale.analysis.reading.table_by_hand import Request
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError
from slipscale.faults.folders import visible

if TYPE_CHECKING:
    from slipscale.analysis.reading.foreign.layouts.layout import Layout
    from slipscale.analysis.reading.meaning.mapping import TableMapping

#: Names of tables in a folder, and the parts of these names that are used.
BIDS_TABLE = re.compile(r"sub-[^_]+(_[^_]+)*_(beh|events)\.tsv")
BIDS_LABEL = re.compile(r"(?<![^_])(sub|ses|task|run)-([^_]+)")
#: Label in file names, keyed by the field of `mapping.Columns` with the same meaning.
IN_NAMES = {"participant": "sub", "session": "ses", "run": "run"}
#: Endings of tables in a folder. Of several, the most frequent one is read, then the first.
TABLES = (
    *(".csv", ".tsv", ".xlsx", ".sav", ".zsav", ".dta", ".mat", ".json", ".jsonl", ".ndjson"),
    *(".txt", ".dat", ".gz"),
)
#: Folders of a data set that contain no tables to read.
NO_TABLES = {"derivatives", "sourcedata", "code"}
#: Proportion of the usual number of rows below which a file is reported as unfinished.
UNFINISHED = 0.9


@dataclass(frozen=True, slots=True)
class Table:
    """A table, and the labels that its name contains (column -> label)."""

    path: Path
    labels: Mapping[str, str]


def read_rows(
    paths: Sequence[Path],
    mapping: TableMapping,
    layout: Layout,
    problems: Problems,
    task: str | None,
) -> tuple[pd.DataFrame, list[Source], tuple[str, ...]]:
    """Read the rows that ``only`` selects.

    Returns
    -------
    frame : DataFrame
        The columns in the mapping, ``file``, ``line``, the participant and, if they are in the
        names of a folder's files, session and run.
    sources : list of Source
        The files that were read.
    left_out : tuple of str
        Names of the files that could not be read.
    """
    (root,) = paths if len(paths) == 1 else (Path(),)
    tables = _tables(paths, mapping, problems, task)
    counts = Counter(table.path.resolve() for table in tables)
    if twice := [path for path, times in counts.items() if times > 1]:
        raise UserError(
            "{path}: this file is named twice, so its answers would be counted twice; expected "
            "each file once",
            path=twice[0],
        )
    read, faults = read_together(
        [table.path for table in tables], _request(tables[0], mapping, layout), root, problems
    )
    if len(tables) == len(faults):
        raise next(iter(faults.values()))
    left_out = tuple(tables[place].path.name for place in faults)
    frames = [frame for frame, _ in read.values()]
    sources = [source for _, source in read.values()]
    for place, frame in zip(read, frames, strict=True):
        for name, label in tables[place].labels.items():
            frame[name] = label
        if mapping.columns.n and mapping.columns.n not in frame:
            frame[mapping.columns.n] = int(mapping.columns.n)
    problems.add_many([f"left out: {error}" for error in faults.values()], "files left out")
    problems.add_many(_copies(sources), "copied files")
    _count(frames, sources, problems)
    filled = [frame for frame in frames if len(frame)] or frames[:1]
    rows = pd.concat(filled, ignore_index=True) if len(filled) > 1 else filled[0]
    if mapping.levels and not {PARTICIPANT, mapping.columns.participant}.intersection(rows):
        # In questionnaires, rows are people.
        rows[PARTICIPANT] = [f"row {place}" for place in range(1, len(rows) + 1)]
        problems.add("no option names the participants, so each row is analysed as one")
    who = mapping.columns.participant or PARTICIPANT
    if len(filled) > 1 and who in rows:
        people = [str(label) for label in rows[who].dropna().unique()]
        alike = check_labels(people, who, "all files")
        problems.add_many(alike, "labels that differ little")
    # A column that is only needed to select rows could have the name of one of Slipscale's columns.
    rows = chosen(rows, mapping.table.only, paths[0])
    named = mapping.columns.named.values()
    events = [mapping.shape.rows_of.column] if mapping.shape.rows_of else []
    kept = {*named, *mapping.levels, *mapping.shape.compared, *events, *IDENTIFIED, "file", "line"}
    unwanted = mapping.table.only if layout.everything else [c for c in rows if c not in kept]
    wanted = [name for name in rows if name not in unwanted]
    return rows[wanted] if len(unwanted) else rows, sources, left_out


#: Columns that may come from the names of files.
IDENTIFIED = tuple(OURS[name] for name in IN_NAMES)


def _copies(sources: Sequence[Source]) -> list[str]:
    """Return notes on files with the same content, whose answers would be counted twice."""
    first: dict[str, str] = {}
    return [
        f"{source.name} has the same content as {first[source.sha256]}, and its answers are "
        "counted as well; if it is a copy, remove it and repeat the analysis"
        for source in sources
        if first.setdefault(source.sha256, source.name) is not source.name
    ]


def _count(frames: Sequence[pd.DataFrame], sources: Sequence[Source], problems: Problems) -> None:
    """Report files without rows, and files with fewer rows than usual."""
    if len(frames) < 2:  # noqa: PLR2004 - several
        return
    sizes = [len(frame) for frame in frames]
    usual = max(Counter(sizes).items(), key=lambda each: (each[1], each[0]))[0]
    names = [source.name for source in sources]
    empty = [name for name, size in zip(names, sizes, strict=True) if not size]
    short = [
        f"{name} ({size})"
        for name, size in zip(names, sizes, strict=True)
        if 0 < size < UNFINISHED * usual
    ]
    if empty:
        problems.add(f"{len(empty)} of {len(names)} files have no rows: {listed(empty)}")
    if short:
        problems.add(
            f"{len(short)} of {len(names)} files have fewer rows than the usual {usual} and may be "
            f"unfinished runs: {listed(short)}"
        )


def _request(table: Table, mapping: TableMapping, layout: Layout) -> Request:
    """Return what is read from each table, whose names have the same labels as this one's."""
    columns = mapping.columns.named
    figures = [columns[name] for name in NUMBERS if name in columns] + list(mapping.levels)
    words = [column for name, column in columns.items() if name not in NUMBERS]
    words += [*mapping.shape.compared, *mapping.table.only]
    words += [mapping.shape.rows_of.column] if mapping.shape.rows_of else []
    words = list(dict.fromkeys(c for c in words if c not in (*figures, *table.labels)))
    figures = [column for column in figures if column not in table.labels]
    # The number of all answers may be stated instead of a column.
    n = columns.get("n", "")
    who = columns.get("participant")
    return Request(
        required=[*words, *(name for name in figures if not (name == n and n.isdigit()))],
        numbers=figures,
        words=words,
        identifier=who if who not in table.labels else None,
        decimal=mapping.table.decimal,
        sheet=mapping.table.sheet,
        header=mapping.shape.header,
        everything=layout.everything,
    )


def _tables(
    paths: Sequence[Path], mapping: TableMapping, problems: Problems, task: str | None
) -> list[Table]:
    """Return the tables in files and folders, with the labels in their names.

    In a BIDS folder, a label is not taken from the names if the mapping names a different column
    for it.

    Raises
    ------
    UserError
        If several tables do not state the participant.
    """
    columns, pattern = mapping.columns.named, mapping.shape.participant_from_name
    found: list[Path] = []
    for path in paths:
        if not path.is_dir():
            found.append(path)
        elif any(visible(path, "sub-*/**/sub-*.tsv")):
            return _of_bids(path, mapping, problems, task)
        else:
            found += in_folder(path, problems)
    if pattern is not None:
        labels = people_in_names(found, pattern)
        if "participant" in columns:
            raise UserError(
                "--participant cannot be combined with --participant-from-name; expected one of "
                "them"
            )
        return [Table(path, {PARTICIPANT: who}) for path, who in zip(found, labels, strict=True)]
    if "participant" in columns or mapping.shape.people_in_columns or mapping.levels:
        return [Table(path, {}) for path in found]
    if len(found) > 1:
        raise UserError(
            "{path} and {more} more: no option names the participants; expected --participant "
            "COLUMN, or --participant-from-name if their labels are in the names of the files",
            path=found[0],
            more=len(found) - 1,
        )
    only = found[0]
    return [Table(only, {PARTICIPANT: "participant" if only == STANDARD_INPUT else only.stem})]


def in_folder(folder: Path, problems: Problems) -> list[Path]:
    """Return the tables in a folder and its subfolders, except results of Slipscale."""
    paths = [
        path
        for path in visible(folder, "**/*")
        if path.suffix.lower() in TABLES and not path.name.startswith("~$")
        if not NO_TABLES.intersection(path.relative_to(folder).parts)
        if not (path.parent / RESULTS).exists()
    ]
    endings = Counter(path.suffix.lower() for path in paths)
    if not endings:
        raise UserError(
            "{folder}: no data found; expected tables ({endings}), or files like "
            "sub-01/beh/sub-01_task-loudness_beh.tsv or ..._events.tsv",
            folder=folder,
            endings=", ".join(TABLES),
        )
    ending = max(endings, key=lambda each: (endings[each], -TABLES.index(each)))
    if others := sum(endings.values()) - endings[ending]:
        problems.add(
            f"{folder.name}: only the {endings[ending]} files with the ending {ending} are read, "
            f"not {others} other tables; to read others, name the files"
        )
    return [path for path in paths if path.suffix.lower() == ending]


def _of_bids(
    folder: Path, mapping: TableMapping, problems: Problems, task: str | None
) -> list[Table]:
    columns = {name: OURS[name] for name in IN_NAMES} | mapping.columns.named
    from_names = {
        columns[name]: label
        for name, label in IN_NAMES.items()
        if columns[name] in (OURS[name], label)
    }
    given = [*mapping.columns.named.values(), *mapping.levels, *mapping.table.only]
    paths = _one_per_run(_of_task(folder, task), frozenset(given) - set(from_names), problems)
    tables = []
    for path in paths:
        of_file = dict(BIDS_LABEL.findall(path.stem))
        prefix = {"sub": "sub-"}
        labels = {
            column: prefix.get(label, "") + of_file.get(label, "")
            for column, label in from_names.items()
        }
        tables.append(Table(path, labels))
    return tables


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
        min(run, key=lambda path: (not needed <= frozenset(header_of(path)), path.name))
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
                "{path}: no row has '{missing}' in column {column}; expected one of {known}",
                path=path,
                missing=absent[0],
                column=column,
                known=known,
            )
        frame = frame[found.isin(wanted)].reset_index(drop=True)
    return frame
