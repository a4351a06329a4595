"""Compare a data set with its journals, and report each difference with its file and row.

If a table and a journal disagree, the journal is taken to be correct. The integrity of a journal is
checked by its running hash and by the number of records stored in the sidecars.
"""

from __future__ import annotations

import csv
import gzip
import io
import json
import zlib
from collections.abc import Iterator, Sequence
from difflib import SequenceMatcher
from itertools import zip_longest
from pathlib import Path, PurePosixPath

from slipscale.experiments.dataset.files import Content, missing_lines
from slipscale.experiments.dataset.former_tables import cut_journals, strays
from slipscale.experiments.dataset.journals import Problem, read_runs
from slipscale.experiments.dataset.rendering import GIT_ATTRIBUTES, README, render
from slipscale.experiments.dataset.schema import SIDECAR
from slipscale.experiments.dataset.withdrawn import RECORD, unfinished
from slipscale.experiments.steps.questions.base import CONSENT
from slipscale.experiments.study.person_questions import TAKEN
from slipscale.faults.message import Message

# Maximum number of similar problems in one file that are reported individually.
TOLD = 20
# Entries of JSON files that are the same in every version of Slipscale.
SETTLED = ("Name", "DatasetType", "License", "Authors", "TaskName")


def verify(dataset: Path) -> list[Problem]:
    """Return all damage in journals, and all differences between files and journals.

    Raises
    ------
    UserError
        If the data set contains both pilots and participants.
    """
    runs, problems = read_runs(dataset)
    problems += [Problem(file=RECORD.as_posix(), what=each) for each in unfinished(dataset)]
    problems += cut_journals(dataset, runs)
    files, unfit = render(runs)
    problems += unfit
    for name, content in files.items():
        if name == GIT_ATTRIBUTES and not missing_lines(dataset / name, str(content)):
            continue  # DataLad adds lines of its own
        if name != README:
            problems += _compare(dataset, name, content)
    for path in strays(dataset, files.keys()):
        file = path.relative_to(dataset).as_posix()
        problems.append(Problem(file=file, what="is not in any journal"))
    return problems


def _compare(dataset: Path, name: PurePosixPath, content: Content) -> list[Problem]:
    """Compare a file with the content generated from the journals, and return the differences."""
    path = dataset / name
    if not path.is_file():
        return [Problem(file=str(name), what="the file is missing; slipscale data build writes it")]
    if isinstance(content, bytes):
        return _compressed(path, str(name), content)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        return [Problem(file=str(name), what=Message("cannot be read ({error})", error=error))]
    if name.suffix == ".tsv":
        problems = list(_rows(str(name), text, str(content)))
    elif isinstance(content, dict):
        problems = list(_entries(str(name), text, content))
    else:
        same = text == content
        problems = [] if same else [Problem(file=str(name), what="differs from the journals")]
    if len(problems) > TOLD:
        more = Problem(
            file=str(name), what=Message("{count} more differences", count=len(problems) - TOLD)
        )
        problems = [*problems[:TOLD], more]
    return problems


def _compressed(path: Path, name: str, content: bytes) -> list[Problem]:
    """Compare the decompressed tables, because versions of zlib compress differently."""
    try:
        same = gzip.decompress(path.read_bytes()) == gzip.decompress(content)
    except (OSError, EOFError, zlib.error) as error:
        return [Problem(file=name, what=Message("cannot be read ({error})", error=error))]
    return [] if same else [Problem(file=name, what="differs from the journals")]


def _rows(name: str, text: str, expected: str) -> Iterator[Problem]:
    """Yield each cell, row or column in which a table differs, with its line number."""
    try:
        there = _cells(text)
    except csv.Error as error:
        yield Problem(file=name, what=Message("is not a table ({error})", error=error))
        return
    header, *rows = _cells(expected)
    if not there or there[0] != header:
        yield Problem(file=name, place="row 1", what="the columns differ from the journal")
        return
    # Equal rows are aligned first, so that a missing or extra row counts as one difference.
    found = [tuple(row) for row in there[1:]]
    aligned = SequenceMatcher(a=[tuple(row) for row in rows], b=found, autojunk=False)
    for same, first, last, begin, end in aligned.get_opcodes():
        if same != "equal":
            pairs = zip_longest(found[begin:end], rows[first:last])
            for number, (row, right) in enumerate(pairs, start=begin + 2):
                yield from _row(name, Message("row {number}", number=number), header, row, right)


def _row(
    name: str,
    place: str,
    header: Sequence[str],
    row: Sequence[str] | None,
    right: Sequence[str] | None,
) -> Iterator[Problem]:
    """Yield the differences between a table row and the row expected from the journal."""
    if row is None:
        what = Message("is missing ({short})", short=_short(right or ()))
    elif right is None:
        what = Message("the row is not in the journal ({short})", short=_short(row))
    elif len(row) != len(right):
        what = Message(
            "{count} cells instead of {expected_count}", count=len(row), expected_count=len(right)
        )
    else:
        for column, cell, wanted in zip(header, row, right, strict=True):
            if cell != wanted:
                different = Message(
                    "{column} is {cell}; the journal has {wanted}",
                    column=column,
                    cell=repr(cell[:40]),
                    wanted=repr(wanted[:40]),
                )
                yield Problem(file=name, place=place, what=different)
        return
    yield Problem(file=name, place=place, what=what)


def _cells(text: str) -> list[list[str]]:
    return list(csv.reader(io.StringIO(text), delimiter="\t", strict=True))


def _short(row: Sequence[str]) -> str:
    return f"begins {' '.join(row)[:40]!r}"


def _entries(name: str, text: str, content: dict[str, object]) -> Iterator[Problem]:
    """Yield the entries of a JSON file that differ from ``content``, ignoring missing entries."""
    try:
        there = _settled(json.loads(text), name)
    except (ValueError, RecursionError) as error:
        yield Problem(file=name, what=Message("cannot be read ({error})", error=error))
        return
    for entry, wanted in _settled(json.loads(json.dumps(content)), name).items():
        if entry in there and there[entry] != wanted:
            yield Problem(file=name, place=entry, what="differs from the journal")


def _in_own_words(file: str, column: str) -> bool:
    """Return whether Slipscale, and not the study, explains the codes of a column."""
    of_study = file.startswith(("participants.json", "phenotype/"))
    return not of_study or column in (*TAKEN, CONSENT)


def _settled(content: object, file: str) -> dict[str, object]:
    """Return the entries that are the same in all versions, such as units and codes.

    The meanings of codes are compared only for the study's questions about the participant. Most
    other meanings are Slipscale's own wording, which can change between versions.
    """
    if not isinstance(content, dict):
        return {}
    if isinstance(content.get(SIDECAR), dict):
        return dict(content[SIDECAR])
    columns = {name: part for name, part in content.items() if isinstance(part, dict)}
    return {name: content[name] for name in SETTLED if name in content} | {
        f"{name}: {key}": sorted(part[key])
        if key == "Levels" and _in_own_words(file, name)
        else part[key]
        for name, part in columns.items()
        for key in ("Units", "Levels")
        if key in part
    }
