"""Preserve data that remain in a data set's tables but no longer in its journals.

Building a data set never loses a row. If a journal was lost, truncated or damaged after its tables
were written, the tables are the only copy. The rules are:

- A run's table is left unchanged if rebuilding it would delete a row, or a value that was lost from
  a damaged journal.
- A run's table is also left unchanged if the run's journal is lost, or is truncated within the
  first record.
- In tables for several participants or sessions, rows that are not in any journal are kept.
  Individual values that are not in any journal are kept only if a journal of the same participant
  was lost, truncated or damaged.
- Preserved data are reported until the journal is restored or the data are deleted.

Rows of participants who withdrew are always removed.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, NamedTuple

from slipscale.experiments.dataset.further_tables.events import events_of
from slipscale.experiments.dataset.journals import Problem, Run
from slipscale.experiments.dataset.rendering import render, stem_of
from slipscale.experiments.dataset.schema import (
    MISSING,
    PARTICIPANT,
    RUN,
    SESSION,
    SIDECAR,
    TABLE_NAME,
)
from slipscale.experiments.dataset.tsv import table
from slipscale.faults.folders import visible
from slipscale.faults.message import Message

if TYPE_CHECKING:
    from slipscale.experiments.dataset.files import Content

# The columns that identify the participant, the session and the run of a row.
KEYS = (PARTICIPANT, SESSION, RUN)
Files = dict["PurePosixPath", "Content"]
Row = dict[str, str]


class Kept(NamedTuple):
    """Files that can be written without loss of data, and the problems to be reported."""

    files: Files
    problems: list[Problem]


def with_former(dataset: Path, runs: Sequence[Run], gone: Collection[str] = ()) -> Kept:
    """Return a data set's files, including data that only its existing tables still contain.

    Parameters
    ----------
    dataset : Path
        Folder of the data set with the existing tables.
    runs : sequence of Run
        Runs read from the journals of the data set.
    gone : collection of str
        Labels of withdrawn participants, whose data are not kept.
    """
    files, problems = render(runs)
    cut = cut_journals(dataset, runs)
    problems += cut
    left = {table for tables in cut.values() for table in tables}
    for run in runs:
        for name in _tables_of(run):
            if name in left or name not in files:
                continue
            if reason := _loses(dataset / name, str(files[name]), damaged=bool(run.damage)):
                left |= _files_of(name)
                problems.append(Problem(file=str(name), what=reason))
    files = {name: content for name, content in files.items() if name not in left}
    known = {path.name for path in left}
    known |= {name.name for run in runs if run.damage for name in _tables_of(run)}
    for path in strays(dataset, [*files, *left]):
        known.add(path.name)
        file = path.relative_to(dataset).as_posix()
        problems.append(Problem(file=file, what="the table is kept, but its journal is missing"))
    lost = {f"sub-{found['sub']}" for name in known if (found := TABLE_NAME.fullmatch(name))}
    without = {f"sub-{label}" for label in gone}
    for name in [name for name in files if name.suffix == ".tsv" and _is_shared(name)]:
        problems += _keep_rows(dataset, name, files, lost=lost, gone=without)
    return Kept(files, problems)


def strays(dataset: Path, files: Collection[PurePosixPath]) -> Iterator[Path]:
    """Yield the tables of runs whose journal is missing."""
    known = {str(name) for name in files}
    for path in visible(dataset, "sub-*/**/beh/*.tsv"):
        if path.relative_to(dataset).as_posix() not in known and TABLE_NAME.fullmatch(path.name):
            yield path


def cut_journals(dataset: Path, runs: Sequence[Run]) -> dict[Problem, list[PurePosixPath]]:
    """Return a problem, with the tables, for each journal that lost data after they were built.

    A journal only grows, so it must still contain the records that the sidecar describes.
    """
    found: dict[Problem, list[PurePosixPath]] = {}
    for run in runs:
        for name in _tables_of(run):
            journal = _own_entries(dataset / name.with_suffix(".json")).get("journal")
            reason = _lost(run, journal) if isinstance(journal, dict) else ""
            if reason:
                file = run.path.relative_to(dataset).as_posix()
                tables = found.setdefault(Problem(file=file, what=reason), [])
                tables += _files_of(name)
    return found


def _own_entries(path: Path) -> dict[str, object]:
    """Return Slipscale's entry in a sidecar, or an empty dict if the sidecar cannot be read."""
    own = _described(path).get(SIDECAR)
    return own if isinstance(own, dict) else {}


def _described(sidecar: Path) -> dict[str, object]:
    try:
        found = json.loads(sidecar.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def _tables_of(run: Run) -> list[PurePosixPath]:
    return [stem_of(run, protocol.task).with_suffix(".tsv") for protocol, _ in run.plan.tasks()]


def _files_of(table: PurePosixPath) -> set[PurePosixPath]:
    """Return a run's table and the files that are only kept together with it."""
    return {table, table.with_suffix(".json"), events_of(table)}


def _is_shared(name: PurePosixPath) -> bool:
    return name.parent.name != "beh"


def _lost(run: Run, entry: dict[str, object]) -> str:
    """Describe what a journal has lost since its sidecar was written, or return an empty string."""
    count, known = entry.get("records"), entry.get("hash")
    if type(count) is not int or count < 1:
        return ""
    if len(run.records) < count:
        return Message(
            "the end of the journal is missing: it has {count} records, but had {count_before} "
            "when its tables were made",
            count=len(run.records),
            count_before=count,
        )
    now = run.records[count - 1].hash
    if known and now and not run.damage and now != known:
        return Message(
            "the first {count} records differ from the records from which the tables were made",
            count=count,
        )
    return ""


def _loses(path: Path, new: str, *, damaged: bool) -> str:
    """Return which data would be lost if a table were rebuilt, or an empty string if none."""
    before, rows = _rows(path), _parse(new)
    if len(before) > len(rows):
        return Message(
            "the table has {in_table} rows, but only {in_journal} are in its journal; the table "
            "was left unchanged. Restore the journal, or delete the table and rebuild the "
            "data set",
            in_table=len(before),
            in_journal=len(rows),
        )
    erased = sum(
        row.get(column) == MISSING and cell != MISSING
        for old, row in zip(before, rows, strict=False)
        for column, cell in old.items()
    )
    if damaged and erased:
        return Message(
            "the table contains {erased} values that were lost from its damaged journal; the "
            "table was left unchanged. Restore the journal, or delete the table and rebuild "
            "the data set",
            erased=erased,
        )
    return ""


def _keep_rows(
    dataset: Path,
    name: PurePosixPath,
    files: Files,
    *,
    lost: Collection[str],
    gone: Collection[str],
) -> Iterator[Problem]:
    """Copy to a new table the rows and values that only the existing table contains."""
    rows, kept = _parse(str(files[name])), list[Row]()
    whose = name.parts[0] if name.parts[0].startswith("sub-") else ""  # the table lists sessions
    for old in _rows(dataset / name):
        person = whose or old.get(PARTICIPANT, "")
        keys = [key for key in KEYS if key in old and key in rows[0]]
        same = [row for row in rows if all(row[key] == old[key] for key in keys)]
        if not keys or person in gone:
            continue
        label = " ".join(old[key] for key in keys)
        if not same:
            kept.append(old)
            yield Problem(
                file=str(name),
                place=label,
                what=(Message("this row is not in any journal; {kept}", kept=KEPT)),
            )
            continue
        erased = [
            column
            for column, cell in old.items()
            if cell != MISSING and same[0].get(column, MISSING) == MISSING
        ]
        if erased and person in lost and len(same) == 1:
            same[0].update({column: old[column] for column in erased})
            values = ", ".join(erased)
            yield Problem(
                file=str(name),
                place=label,
                what=(Message("no journal contains {values}; {kept}", values=values, kept=KEPT)),
            )
    rows += kept
    header = [*dict.fromkeys(column for row in rows for column in row)]
    if kept:
        rows.sort(key=lambda row: [row.get(key, "") for key in KEYS])
    former = _described(dataset / name.with_suffix(".json"))
    columns = files[name.with_suffix(".json")]
    for column in header:
        if isinstance(columns, dict) and column not in columns and column in former:
            columns[column] = former[column]
    files[name] = table(header, [[row.get(column, MISSING) for column in header] for row in rows])


KEPT = "the row was kept. Restore the journal, or delete the row and rebuild the data set"


def _rows(path: Path) -> list[Row]:
    """Return the rows of a table, or an empty list if the table is missing or cannot be read."""
    try:
        return _parse(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, csv.Error):
        return []


def _parse(text: str) -> list[Row]:
    reader = csv.DictReader(io.StringIO(text), delimiter="\t", strict=True, restval=MISSING)
    return [{k: v for k, v in row.items() if k is not None} for row in reader]
