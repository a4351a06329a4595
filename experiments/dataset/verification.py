"""A data set compared with its journals: what differs, by file and row.

The journals are the source of truth. That they themselves are whole is told by their running hash
and by the sidecars, which hold how many records there were when the tables were made.
"""

from __future__ import annotations

import csv
import io
import json
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

from slipscale.experiments.dataset.journals import Problem, read_runs
from slipscale.experiments.dataset.rendering import README, render, stem_of
from slipscale.experiments.dataset.schema import SIDECAR, TABLE_NAME

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path, PurePosixPath

    from slipscale.experiments.dataset.journals import Run
    from slipscale.experiments.dataset.rendering import Content

# Problems of one kind in one file that are told one by one.
TOLD = 20


def verify(dataset: Path) -> list[Problem]:
    """Return all that is damaged in a data set's journals and all that differs from them.

    Raises
    ------
    UserError
        It holds both pilots and participants.
    """
    runs, problems = read_runs(dataset)
    problems += cut_journals(dataset, runs)
    files, unfit = render(runs)
    problems += unfit
    for name, content in files.items():
        if name != README:
            problems += _compare(dataset, name, content)
    return [*problems, *_strays(dataset, files)]


def cut_journals(dataset: Path, runs: Sequence[Run]) -> dict[Problem, list[PurePosixPath]]:
    """Return which journals are not what they were when their tables were made, and these tables.

    A journal only grows: what the sidecar says of it must still be found in it.
    """
    found: dict[Problem, list[PurePosixPath]] = {}
    for run in runs:
        for protocol, _ in run.plan.tasks():
            stem = stem_of(run, protocol.task)
            told = _sidecar(dataset / stem.with_suffix(".json")).get("journal")
            if not isinstance(told, dict):
                continue
            reason = _lost(run, told)
            if reason:
                file = run.path.relative_to(dataset).as_posix()
                problem = Problem(file=file, what=reason)
                tables = found.setdefault(problem, [])
                tables += [stem.with_suffix(ending) for ending in (".tsv", ".json")]
    return found


def _lost(run: Run, told: dict[str, Any]) -> str:
    """Return what a journal has lost since a sidecar was written; nothing if it holds it all."""
    count, known = told.get("records"), told.get("hash")
    if type(count) is not int or count < 1:
        return ""
    if len(run.records) < count:
        return (
            f"its end is missing: {len(run.records)} records, and there were {count} when its "
            "tables were made"
        )
    now = run.records[count - 1].hash
    if known and now and not run.damage and now != known:
        return f"its first {count} records are not those that its tables were made from"
    return ""


def _sidecar(path: Path) -> dict[str, Any]:
    """Return our object of a sidecar, empty where there is none that can be read."""
    try:
        own = json.loads(path.read_text(encoding="utf-8"))[SIDECAR]
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return {}
    return own if isinstance(own, dict) else {}


def _compare(dataset: Path, name: PurePosixPath, content: Content) -> list[Problem]:
    """Return how a file differs from what the journals give."""
    path = dataset / name
    if not path.is_file():
        return [Problem(file=str(name), what="is not there; slipscale data build writes it")]
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        return [Problem(file=str(name), what=f"cannot be read ({error})")]
    if name.suffix == ".tsv":
        problems = list(_rows(str(name), text, str(content)))
    elif isinstance(content, str):
        same = text == content
        problems = [] if same else [Problem(file=str(name), what="differs from the journals'")]
    elif SIDECAR in content:
        problems = list(_notes(str(name), _sidecar(path), content[SIDECAR]))
    else:
        # Descriptions of columns: another version of Slipscale may word them otherwise.
        problems = []
    if len(problems) > TOLD:
        more = Problem(file=str(name), what=f"{len(problems) - TOLD} differences more")
        problems = [*problems[:TOLD], more]
    return problems


def _rows(name: str, text: str, expected: str) -> Iterator[Problem]:
    """Yield the cells, rows and columns in which a table differs; the row is the file's line."""
    try:
        there = _cells(text)
    except csv.Error as error:
        yield Problem(file=name, what=f"is no table ({error})")
        return
    header, *rows = _cells(expected)
    if not there or there[0] != header:
        yield Problem(file=name, place="row 1", what="other columns than the journal gives")
        return
    for number, (row, right) in enumerate(zip_longest(there[1:], rows), start=2):
        place = f"row {number}"
        if row is None:
            yield Problem(file=name, place=place, what=f"is missing ({_short(right)})")
        elif right is None:
            yield Problem(file=name, place=place, what=f"is not in the journal ({_short(row)})")
        elif len(row) != len(right):
            yield Problem(file=name, place=place, what=f"{len(row)} cells for {len(right)}")
        else:
            for column, cell, wanted in zip(header, row, right, strict=True):
                if cell != wanted:
                    what = f"{column} is {cell[:40]!r}; the journal says {wanted[:40]!r}"
                    yield Problem(file=name, place=place, what=what)


def _cells(text: str) -> list[list[str]]:
    return list(csv.reader(io.StringIO(text), delimiter="\t", strict=True))


def _short(row: list[str]) -> str:
    return f"begins {' '.join(row)[:40]!r}"


def _notes(name: str, there: dict[str, Any], right: dict[str, Any]) -> Iterator[Problem]:
    """Yield the entries in which a sidecar differs; later versions' entries may be absent."""
    for key, value in right.items():
        if key in there and there[key] != json.loads(json.dumps(value)):
            yield Problem(file=name, place=key, what="differs from the journal's")


def _strays(dataset: Path, files: dict[PurePosixPath, Content]) -> Iterator[Problem]:
    """Yield the tables that no journal gives."""
    known = {str(name) for name in files}
    for path in sorted(dataset.glob("sub-*/**/beh/*.tsv")):
        name = path.relative_to(dataset).as_posix()
        if name not in known and TABLE_NAME.fullmatch(path.name):
            yield Problem(file=name, what="no journal gives it")
